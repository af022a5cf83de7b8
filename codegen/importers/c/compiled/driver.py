"""The program around a file of C that was written again (unit.py): rows in, answers out, nothing else.

Does: limits itself in time, memory, files and processes; reads rows of doubles; prints an answer a line.
Assumes: POSIX for the limits; elsewhere only time is limited (builds.py).
Does not: know what is asked. What the program prints by itself goes nowhere.
"""

DRIVER = r"""
#include <setjmp.h>
#include <stdio.h>
#include <stdlib.h>
#if defined(__unix__) || defined(__APPLE__)
#include <sys/resource.h>
#include <unistd.h>
static void limit(int what, rlim_t most) {
    struct rlimit both = {most, most};
    if (setrlimit(what, &both)) exit(3);
}
static void limits(void) {
    limit(RLIMIT_CPU, 60);
    limit(RLIMIT_AS, (rlim_t)4 << 30);
    limit(RLIMIT_FSIZE, 0);
    limit(RLIMIT_CORE, 0);
#ifdef RLIMIT_NPROC
    limit(RLIMIT_NPROC, 0);
#endif
}
#else
#define dup _dup
#define fdopen _fdopen
int dup(int);
FILE *fdopen(int, const char *);
static void limits(void) {}
#endif

extern int (*maviper_doors[])(const double *, int);
void maviper_numbers(void);
static FILE *out;
static jmp_buf failed;

void maviper_number(double value) { fprintf(out, "%a ", value); }
void maviper_whole(long long value) { fprintf(out, "%lld ", value); }
void maviper_natural(unsigned long long value) { fprintf(out, "%llu ", value); }
void maviper_say(const char *word) { fprintf(out, "%s ", word); }
void maviper_letter(char value) { fprintf(out, "c%d ", value); }
void maviper_text(const char *value) {
    fputs("t", out);
    for (; value && *value; value++) fprintf(out, "%02x", (unsigned)(unsigned char)*value);
    fputs(" ", out);
}
void maviper_fail(void) { longjmp(failed, 1); }

/* DRIVER numbers | DRIVER FUNCTION WIDTH MODE; mode 1: each answer at once, 2: whether a row can be handed over */
int main(int n, char **given) {
    out = fdopen(dup(1), "w");
    if (!out || !freopen("/dev/null", "w", stdout)) return 3;
    limits();
    if (n < 4) {
        setvbuf(out, 0, _IONBF, 0);
        maviper_numbers();
        return fclose(out) != 0;
    }
    int function = atoi(given[1]), mode = atoi(given[3]);
    volatile int row = mode & 2;
    size_t width = (size_t)atol(given[2]);
    double *in = malloc((width + 1) * sizeof *in);
    if (!in) return 3;
    maviper_doors[function](0, 0);
    fputs("\n", out);
    for (; fread(in, sizeof *in, width, stdin) == width; row ^= 1) {
        if (setjmp(failed)) fputs("!", out);
        else if (!maviper_doors[function](in, row)) fputs("-", out);
        fputs("\n", out);
        if (mode == 1) fflush(out);
    }
    free(in);
    return fclose(out) != 0;
}
"""
