/* The zone search of search.py, compiled: the same walks, the same bytes, the same counts.
 *
 * Bounds are integers of 128 or of 256 bits, whichever holds every sum that can arise; the caller chooses. The file
 * includes itself once for each width. Formulas come packed as 32-bit integers:
 *
 *   flat:   number of bounds, the bounds, number of choices, the choices
 *   choice: its length, number of parts, the parts
 *   part:   its id, its length, its flat formula
 */

#ifndef WIDTH

#define PY_SSIZE_T_CLEAN
#include <Python.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#ifndef __SIZEOF_INT128__
#error "needs 128-bit integers"
#endif

#define MAX_TABLED (1 << 22) /* combinations of classes that are looked up in a table instead of a dictionary */
#define SIGNALS 0xffff        /* nodes between two looks for Ctrl-C */
#define MAX_LEVELS 4096       /* of the recursion: a deeper search counts as one whose budget ended */

enum { CLOSED = 0, OPEN = 1, FAILED = -1 };

typedef struct {
    uint8_t *data;
    size_t size, room;
} Buffer;

static int grow(void **data, size_t *room, size_t need, size_t item)
{
    if (need <= *room)
        return 1;
    size_t larger = need + need / 2 + 64;
    void *moved = realloc(*data, larger * item);
    if (!moved) {
        PyErr_NoMemory();
        return 0;
    }
    *data = moved;
    *room = larger;
    return 1;
}

static int put(Buffer *out, uint64_t number)
{
    if (!grow((void **)&out->data, &out->room, out->size + 10, 1))
        return 0;
    while (number > 127) {
        out->data[out->size++] = (uint8_t)(number | 128);
        number >>= 7;
    }
    out->data[out->size++] = (uint8_t)number;
    return 1;
}

/* what does not depend on the width */
typedef struct {
    int components, agents, parts, n_edges;
    const int32_t *sizes, *edges, *pool; /* edges: component, upper, lower */
    const int32_t **trees;               /* agent -> [n][4]: left, right, and the sides' places in the pool or -1 */
    const int32_t **classes;             /* agent -> [n], NULL in a walk for lemmas */
    const int32_t *denials;              /* [n][parts]: places in the pool or -1, at leaves; NULL in other walks */
    const int64_t *allowed;              /* [n] or NULL */
    int64_t *masks;                      /* [n] */
    int32_t *known;                      /* agent -> class */
    size_t *strides;
    const int32_t **table; /* combination -> denial, &unknown, or NULL where it is false */
    PyObject *resolve;
    uint64_t nodes, budget;
    int exhausted;
    int32_t *path, *chosen;
    size_t path_room, chosen_room;
    const int32_t **pending; /* choices still to make, those of a search node in one piece */
    size_t pending_room;
    Buffer out, aside;
    unsigned long long wanted, collected; /* open branches to go on after; 0: the search ends at the first */
    int32_t *leaf;                        /* agent -> where it ended */
    Buffer open;                          /* of each collected branch the agents' leaves and the closed matrices */
} Search;

static int keep(Buffer *out, const void *data, size_t size)
{
    if (!grow((void **)&out->data, &out->room, out->size + size, 1))
        return 0;
    memcpy(out->data + out->size, data, size);
    out->size += size;
    return 1;
}

static const int32_t unknown;

/* the claim's denial where the agents stand: NULL when false, &unknown after an error */
static const int32_t *denial(Search *s)
{
    size_t place = 0;
    if (s->table) {
        for (int k = 0; k < s->agents; k++)
            place += (size_t)s->known[k] * s->strides[k];
        if (s->table[place] != &unknown)
            return s->table[place];
    }
    PyObject *numbers = PyTuple_New(s->agents);
    if (!numbers)
        return &unknown;
    for (int k = 0; k < s->agents; k++)
        PyTuple_SET_ITEM(numbers, k, PyLong_FromLong(s->known[k]));
    PyObject *found = PyObject_CallOneArg(s->resolve, numbers);
    Py_DECREF(numbers);
    if (!found)
        return &unknown;
    const int32_t *packed = found == Py_None ? NULL : (const int32_t *)PyBytes_AS_STRING(found);
    Py_DECREF(found); /* the caller's cache keeps it */
    if (s->table)
        s->table[place] = packed;
    return packed;
}

#define JOIN_(a, b) a##b
#define JOIN(a, b) JOIN_(a, b)
#define NAME(x) JOIN(x, WIDTH)

#define WIDTH 128
#include "_zones.c"
#undef WIDTH
#define WIDTH 256
#include "_zones.c"
#undef WIDTH

static const int32_t *ints(PyObject *bytes)
{
    return (const int32_t *)PyBytes_AS_STRING(bytes);
}

static void release(Search *s)
{
    free(s->trees);
    free(s->classes);
    free(s->known);
    free(s->strides);
    free(s->table);
    free(s->path);
    free(s->chosen);
    free(s->pending);
    free(s->masks);
    free(s->out.data);
    free(s->aside.data);
    free(s->leaf);
    free(s->open.data);
}

static int lay_out(Search *s, PyObject *trees, PyObject *classes)
{
    s->agents = (int)PyTuple_GET_SIZE(trees);
    size_t room = (size_t)s->agents + 1;
    s->trees = calloc(room, sizeof *s->trees);
    s->classes = calloc(room, sizeof *s->classes);
    s->known = calloc(room, sizeof *s->known);
    s->strides = calloc(room, sizeof *s->strides);
    s->leaf = calloc(room, sizeof *s->leaf);
    if (!s->trees || !s->classes || !s->known || !s->strides || !s->leaf)
        return 0;
    double total = 1;
    size_t stride = 1;
    for (int k = 0; k < s->agents; k++) {
        s->trees[k] = ints(PyTuple_GET_ITEM(trees, k));
        if (classes == Py_None)
            continue;
        PyObject *own = PyTuple_GET_ITEM(classes, k);
        s->classes[k] = ints(own);
        s->known[k] = s->classes[k][0];
        int32_t most = 0;
        for (Py_ssize_t v = 0; v < PyBytes_GET_SIZE(own) / 4; v++)
            most = s->classes[k][v] > most ? s->classes[k][v] : most;
        total *= most + 1;
        if (total > MAX_TABLED)
            continue;
        s->strides[k] = stride;
        stride *= (size_t)most + 1;
    }
    if (classes != Py_None && total <= MAX_TABLED) {
        s->table = malloc(stride * sizeof *s->table);
        if (!s->table)
            return 0;
        for (size_t place = 0; place < stride; place++)
            s->table[place] = &unknown;
    }
    return 1;
}

/* walk(width, sizes, edges, weights, infinite, pool, region, agent, trees, classes, resolve, denials, parts, allowed,
 *      nodes, budget, wanted) -> (status or None when the budget ended, nodes, bytes, bounds of the open branch, masks,
 *      collected branches)
 */
static PyObject *walk(PyObject *module, PyObject *arguments)
{
    (void)module;
    int width, region, agent, parts;
    unsigned long long nodes, budget, wanted;
    PyObject *sizes, *edges, *weights, *infinite, *pool, *trees, *classes, *resolve, *denials, *allowed;
    if (!PyArg_ParseTuple(arguments, "iSSSSSiiO!OOOiOKKK", &width, &sizes, &edges, &weights, &infinite, &pool, &region,
                          &agent, &PyTuple_Type, &trees, &classes, &resolve, &denials, &parts, &allowed, &nodes,
                          &budget, &wanted))
        return NULL;
    Search s = {0};
    s.components = (int)(PyBytes_GET_SIZE(sizes) / 4);
    s.sizes = ints(sizes);
    s.edges = ints(edges);
    s.n_edges = (int)(PyBytes_GET_SIZE(edges) / 12);
    s.pool = ints(pool);
    s.resolve = resolve;
    s.nodes = nodes;
    s.budget = budget;
    s.wanted = wanted;
    s.parts = parts;
    size_t first_nodes = 0;
    PyObject *result = NULL;
    if (!lay_out(&s, trees, classes)) {
        PyErr_NoMemory();
        goto end;
    }
    if (denials != Py_None) {
        s.denials = ints(denials);
        s.allowed = allowed == Py_None ? NULL : (const int64_t *)PyBytes_AS_STRING(allowed);
        first_nodes = (size_t)PyBytes_GET_SIZE(PyTuple_GET_ITEM(trees, 0)) / 16;
        s.masks = malloc(first_nodes * sizeof *s.masks);
        if (!s.masks) {
            PyErr_NoMemory();
            goto end;
        }
        memset(s.masks, 0xff, first_nodes * sizeof *s.masks);
    }
    const char *numbers = PyBytes_AS_STRING(weights), *large = PyBytes_AS_STRING(infinite);
    size_t length = 0;
    int status = width == 128 ? start128(&s, numbers, large, s.pool + region, agent, &length)
                              : start256(&s, numbers, large, s.pool + region, agent, &length);
    if (status == FAILED && !s.exhausted)
        goto end;
    result = Py_BuildValue("NKy#y#y#y#", s.exhausted ? Py_NewRef(Py_None) : PyLong_FromLong(status),
                           (unsigned long long)s.nodes, s.out.data ? (const char *)s.out.data : "",
                           (Py_ssize_t)s.out.size, s.path ? (const char *)s.path : "",
                           (Py_ssize_t)(status == OPEN ? length * 4 : 0), s.masks ? (const char *)s.masks : "",
                           (Py_ssize_t)(first_nodes * 8), s.open.data ? (const char *)s.open.data : "",
                           (Py_ssize_t)s.open.size);
end:
    release(&s);
    return result;
}

static PyMethodDef methods[] = {{"walk", walk, METH_VARARGS, "One walk of the zone search."}, {NULL, NULL, 0, NULL}};
static struct PyModuleDef definition = {PyModuleDef_HEAD_INIT, "_zones", NULL, -1, methods, NULL, NULL, NULL, NULL};

PyMODINIT_FUNC PyInit__zones(void)
{
    return PyModule_Create(&definition);
}

#else /* once for each width */

#if WIDTH == 128
typedef __int128 Weight128;
#define PLUS(a, b) ((a) + (b))
#define LESS(a, b) ((a) < (b))
#define NEGATIVE(a) ((a) < 0)
#else
typedef struct {
    unsigned __int128 low;
    __int128 high;
} Weight256;
static inline Weight256 plus256(Weight256 a, Weight256 b)
{
    Weight256 sum;
    sum.low = a.low + b.low;
    sum.high = a.high + b.high + (sum.low < a.low);
    return sum;
}
#define PLUS(a, b) plus256(a, b)
#define LESS(a, b) ((a).high < (b).high || ((a).high == (b).high && (a).low < (b).low))
#define NEGATIVE(a) ((a).high < 0)
#endif

#define Weight NAME(Weight)

/* the zone at one level of the search: a matrix for each component, its own or the level's above */
typedef struct {
    Weight **bounds;
    int32_t **steps;
    Weight **own_bounds;
    int32_t **own_steps;
} NAME(Level);
#define Level NAME(Level)

typedef struct {
    Search *s;
    Weight *weights;
    Level *levels;
    size_t count, room;
    size_t open; /* length of the open branch */
} NAME(Walk);
#define Walk NAME(Walk)

static int NAME(deeper)(Walk *w, size_t depth)
{
    if (depth < w->count)
        return 1;
    if (!grow((void **)&w->levels, &w->room, depth + 1, sizeof(Level)))
        return 0;
    Search *s = w->s;
    Level *level = &w->levels[w->count];
    size_t n = (size_t)s->components;
    level->bounds = calloc(n, sizeof(Weight *));
    level->steps = calloc(n, sizeof(int32_t *));
    level->own_bounds = calloc(n, sizeof(Weight *));
    level->own_steps = calloc(n, sizeof(int32_t *));
    w->count++;
    int good = level->bounds && level->steps && level->own_bounds && level->own_steps;
    for (size_t c = 0; good && c < n; c++) {
        size_t cells = (size_t)s->sizes[c] * (size_t)s->sizes[c];
        level->own_bounds[c] = malloc(cells * sizeof(Weight));
        level->own_steps[c] = malloc(cells * sizeof(int32_t));
        good = level->own_bounds[c] && level->own_steps[c];
    }
    if (!good)
        PyErr_NoMemory();
    return good;
}

/* adds the bounds of a flat formula to the branch and to the level's zone; CLOSED when they empty it */
static int NAME(add)(Walk *w, Level *level, size_t kept, const int32_t *flat)
{
    Search *s = w->s;
    int32_t n_edges = *flat++;
    if (!grow((void **)&s->path, &s->path_room, kept + (size_t)n_edges + 1, sizeof(int32_t)))
        return FAILED;
    for (int32_t e = 0; e < n_edges; e++) {
        int32_t number = flat[e], place = (int32_t)kept + e;
        const int32_t *edge = s->edges + 3 * (size_t)number;
        int32_t c = edge[0], a = edge[1], b = edge[2], size = s->sizes[c];
        Weight weight = w->weights[number];
        Weight *bounds = level->bounds[c];
        int32_t *steps = level->steps[c];
        s->path[place] = number;
        if (NEGATIVE(PLUS(bounds[b * size + a], weight))) {
            int32_t length = 1;
            for (int32_t from = b; from != a; length++)
                from = s->edges[3 * (size_t)s->path[steps[from * size + a]] + 2];
            if (!put(&s->out, (uint64_t)length) || !put(&s->out, (uint64_t)place))
                return FAILED;
            for (int32_t from = b; from != a;) {
                int32_t step = steps[from * size + a];
                if (!put(&s->out, (uint64_t)step))
                    return FAILED;
                from = s->edges[3 * (size_t)s->path[step] + 2];
            }
            return CLOSED;
        }
        if (!LESS(weight, bounds[a * size + b]))
            continue;
        if (bounds != level->own_bounds[c]) {
            size_t cells = (size_t)size * (size_t)size;
            bounds = level->bounds[c] = memcpy(level->own_bounds[c], bounds, cells * sizeof(Weight));
            steps = level->steps[c] = memcpy(level->own_steps[c], steps, cells * sizeof(int32_t));
        }
        Weight *after = bounds + b * size;
        for (int32_t i = 0; i < size; i++) {
            Weight *row = bounds + i * size;
            Weight here = PLUS(row[a], weight);
            if (!LESS(here, row[b]))
                continue; /* the triangle over b gives no smaller bound either */
            int32_t step = i == a ? place : steps[i * size + a];
            for (int32_t j = 0; j < size; j++) {
                Weight sum = PLUS(here, after[j]);
                if (LESS(sum, row[j])) {
                    row[j] = sum;
                    steps[i * size + j] = step;
                }
            }
        }
    }
    return OPEN;
}

static const int32_t *NAME(choices)(const int32_t *flat)
{
    return flat + 1 + *flat;
}

static int NAME(passed_over)(const Search *s, const int32_t *choice, size_t base, size_t top)
{
    const int32_t *part = choice + 2;
    for (int32_t k = 0; k < choice[1]; k++, part += 2 + part[1])
        for (size_t c = base; c < top; c++)
            if (s->chosen[c] == part[0])
                return 1;
    return 0;
}

/* keeps an open branch, and closes it so that the search goes on; OPEN when it was the last one wanted */
static int NAME(collect)(Search *s, const Level *level)
{
    s->out.size = 0; /* nobody reads the stream of a search that does not refute */
    if (!keep(&s->open, s->leaf, (size_t)s->agents * sizeof(int32_t)))
        return FAILED;
    for (int c = 0; c < s->components; c++)
        if (!keep(&s->open, level->bounds[c], (size_t)s->sizes[c] * (size_t)s->sizes[c] * sizeof(Weight)))
            return FAILED;
    return ++s->collected == s->wanted ? OPEN : CLOSED;
}

/* puts a node's choices and those of a formula at the end of `pending`, in this order */
static int NAME(append)(Search *s, size_t ors, size_t n_ors, size_t end, const int32_t *more)
{
    if (!grow((void **)&s->pending, &s->pending_room, end + n_ors + (size_t)more[0], sizeof(int32_t *)))
        return 0;
    if (n_ors)
        memcpy(s->pending + end, s->pending + ors, n_ors * sizeof(int32_t *));
    const int32_t *choice = more + 1;
    for (int32_t k = 0; k < more[0]; k++, choice += choice[0])
        s->pending[end + n_ors + (size_t)k] = choice;
    return 1;
}

/* one search node and all below it; `ors`: where in `pending` its `n_ors` choices begin, `end`: where others may be put */
static int NAME(visit)(Walk *w, size_t depth, size_t kept, const int32_t *flat, size_t ors, size_t n_ors, size_t end,
                       size_t base, size_t top, int agent, int32_t node)
{
    Search *s = w->s;
    if (++s->nodes > s->budget || depth > MAX_LEVELS) {
        s->exhausted = 1;
        return FAILED;
    }
    if ((s->nodes & SIGNALS) == 0 && PyErr_CheckSignals())
        return FAILED;
    if (agent >= 0 && s->resolve != Py_None) {
        const int32_t *here = denial(s);
        if (here == &unknown)
            return FAILED;
        if (!here)
            return CLOSED;
    }
    if (!NAME(deeper)(w, depth))
        return FAILED;
    Level *level = &w->levels[depth], *above = &w->levels[depth - 1];
    memcpy(level->bounds, above->bounds, (size_t)s->components * sizeof(Weight *));
    memcpy(level->steps, above->steps, (size_t)s->components * sizeof(int32_t *));
    int added = NAME(add)(w, level, kept, flat);
    if (added != OPEN)
        return added;
    if (!put(&s->out, 0))
        return FAILED;
    kept += (size_t)flat[0];
    const int32_t *more = NAME(choices)(flat);
    if (more[0]) {
        if (!NAME(append)(s, ors, n_ors, end, more))
            return FAILED;
        ors = end;
        n_ors += (size_t)more[0];
        end += n_ors;
    }
    for (; n_ors && NAME(passed_over)(s, s->pending[ors], base, top); n_ors--)
        ors++;
    if (n_ors) {
        const int32_t *choice = s->pending[ors], *part = choice + 2;
        for (int32_t k = 0; k < choice[1]; k++, part += 2 + part[1]) {
            if (!grow((void **)&s->chosen, &s->chosen_room, top + 1, sizeof(int32_t)))
                return FAILED;
            s->chosen[top] = part[0];
            int done = NAME(visit)(w, depth + 1, kept, part + 2, ors + 1, n_ors - 1, end, base, top + 1, agent, node);
            if (done != CLOSED)
                return done;
        }
        return CLOSED;
    }
    if (agent < 0) {
        w->open = kept;
        return s->wanted ? NAME(collect)(s, level) : OPEN;
    }
    while (agent < s->agents && s->trees[agent][4 * (size_t)node] < 0) {
        if (s->denials) {
            int64_t mask = 0;
            Buffer out = s->out;
            s->out = s->aside;
            s->out.size = 0;
            for (int bit = 0; bit < s->parts; bit++) {
                if (s->allowed && !(s->allowed[node] >> bit & 1))
                    continue;
                int32_t place = s->denials[(size_t)node * (size_t)s->parts + (size_t)bit];
                size_t mark = s->out.size;
                int done = place < 0 ? CLOSED
                                     : NAME(visit)(w, depth + 1, kept, s->pool + place, end, 0, end, top, top, -1, 0);
                if (done == CLOSED)
                    mask |= (int64_t)1 << bit;
                else
                    s->out.size = mark;
                if (done == FAILED) {
                    s->aside = s->out;
                    s->out = out;
                    return FAILED;
                }
            }
            s->aside = s->out;
            s->out = out;
            s->masks[node] &= mask;
            if (!put(&s->out, (uint64_t)mask) ||
                !grow((void **)&s->out.data, &s->out.room, s->out.size + s->aside.size, 1))
                return FAILED;
            if (s->aside.size)
                memcpy(s->out.data + s->out.size, s->aside.data, s->aside.size);
            s->out.size += s->aside.size;
        }
        s->leaf[agent++] = node;
        node = 0;
    }
    if (agent == s->agents) {
        if (s->denials)
            return CLOSED;
        const int32_t *last = denial(s);
        if (last == &unknown)
            return FAILED;
        return last ? NAME(visit)(w, depth + 1, kept, last, end, 0, end, top, top, -1, 0) : CLOSED;
    }
    const int32_t *row = s->trees[agent] + 4 * (size_t)node;
    for (int side = 0; side < 2; side++) {
        if (row[2 + side] < 0)
            continue;
        int32_t before = s->known[agent];
        if (s->classes[agent])
            s->known[agent] = s->classes[agent][row[side]];
        int done = NAME(visit)(w, depth + 1, kept, s->pool + row[2 + side], end, 0, end, top, top, agent, row[side]);
        s->known[agent] = before;
        if (done != CLOSED)
            return done;
    }
    return CLOSED;
}

static Weight NAME(weight)(const char *bytes)
{
    Weight found;
    memcpy(&found, bytes, sizeof found); /* little-endian, two's complement */
    return found;
}

static int NAME(start)(Search *s, const char *numbers, const char *large, const int32_t *region, int agent,
                       size_t *length)
{
    Walk w = {s, malloc(((size_t)s->n_edges + 1) * sizeof(Weight)), NULL, 0, 0, 0};
    int status = FAILED;
    if (!w.weights) {
        PyErr_NoMemory();
        return FAILED;
    }
    for (int e = 0; e < s->n_edges; e++)
        w.weights[e] = NAME(weight)(numbers + (size_t)e * sizeof(Weight));
    if (NAME(deeper)(&w, 0)) {
        Level *whole = &w.levels[0];
        char zero[sizeof(Weight)] = {0};
        for (int c = 0; c < s->components; c++) {
            size_t size = (size_t)s->sizes[c];
            for (size_t cell = 0; cell < size * size; cell++) {
                whole->own_bounds[c][cell] = NAME(weight)(cell % (size + 1) ? large : zero);
                whole->own_steps[c][cell] = -1;
            }
            whole->bounds[c] = whole->own_bounds[c];
            whole->steps[c] = whole->own_steps[c];
        }
        status = NAME(visit)(&w, 1, 0, region, 0, 0, 0, 0, 0, agent, 0);
    }
    *length = w.open;
    for (size_t depth = 0; depth < w.count; depth++) {
        Level *level = &w.levels[depth];
        for (int c = 0; c < s->components; c++) {
            free(level->own_bounds ? level->own_bounds[c] : NULL);
            free(level->own_steps ? level->own_steps[c] : NULL);
        }
        free(level->bounds);
        free(level->steps);
        free(level->own_bounds);
        free(level->own_steps);
    }
    free(w.levels);
    free(w.weights);
    return status;
}

#undef Weight
#undef Level
#undef Walk
#undef PLUS
#undef LESS
#undef NEGATIVE

#endif
