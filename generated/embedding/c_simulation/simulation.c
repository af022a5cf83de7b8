/* Physical deception in C99, played by the generated policies. libc only. Build and run, in this folder:
 *
 *   cc -std=c99 -O2 -ffp-contract=off simulation.c -o simulation && ./simulation
 *
 *   simulation [--episodes N] [--seed S] [--each]    starts of its own
 *   simulation --starts FILE [--each]                starts from a file, one a line: the goal landmark's number, then
 *                                                    x and y of adversary_0, agent_0, agent_1, landmark_0, landmark_1
 *
 * --each prints a line an episode: adversary's success, defenders' success, each step's actions, where the agents ended.
 * The game is mpe2's simple_adversary, in the order of its float64 operations: a step moves each agent by a tenth of its
 * old velocity, then the velocity is three quarters of what it was, plus half a unit along the action.
 */
#include "../../physical_deception/physical_deception.h"
#include <errno.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define AGENTS 3
#define LANDMARKS 2
#define STEPS 25
#define DT 0.1
#define DAMPING 0.25
#define FORCE 5.0
#define SQUARED_RADIUS 0.1 /* of success: the radius is its root, 0.316 */
#define LONGEST_LINE 1024

/* Places in the world that the header reads: x of an entity, y behind it. */
#define POSITION(entity) (PHYSICAL_DECEPTION_W_ADVERSARY_0_X + 2 * (entity))
#define LANDMARK(index) (PHYSICAL_DECEPTION_W_LANDMARK_0_X + 2 * (index))
#define VELOCITY(agent) (PHYSICAL_DECEPTION_W_ADVERSARY_0_VX + 2 * (agent))

typedef struct {
    int adversary; /* was within the radius of the goal after some step */
    int defenders; /* after some one step each landmark had a defender of its own within the radius */
    int actions[STEPS][AGENTS];
} Episode;

typedef struct {
    long episodes;
    uint64_t seed; /* of the first episode; the next ones count up */
    const char *starts;
    int each;
} Options;

/* splitmix64 (Steele, Lea and Flood 2014): the state counts up by an odd constant, the output mixes its bits. */
static uint64_t next_bits(uint64_t *state)
{
    uint64_t z = (*state += UINT64_C(0x9e3779b97f4a7c15));
    z = (z ^ (z >> 30)) * UINT64_C(0xbf58476d1ce4e5b9);
    z = (z ^ (z >> 27)) * UINT64_C(0x94d049bb133111eb);
    return z ^ (z >> 31);
}

/* Uniform in [-1, 1): the upper 53 bits, so that every step is exact. */
static double next_coordinate(uint64_t *state)
{
    return (double)(next_bits(state) >> 11) * 0x1p-52 - 1.0;
}

/* A world at rest, from the goal's number and the positions of agents and landmarks. */
static void place(double *w, int goal, const double *position)
{
    int i;
    memset(w, 0, PHYSICAL_DECEPTION_N_COORDINATES * sizeof *w);
    for (i = 0; i < 2 * (AGENTS + LANDMARKS); i++) {
        w[POSITION(0) + i] = position[i];
    }
    w[PHYSICAL_DECEPTION_W_GOAL_X] = w[LANDMARK(goal)];
    w[PHYSICAL_DECEPTION_W_GOAL_Y] = w[LANDMARK(goal) + 1];
}

/* The start of one episode: its generator's state starts as its seed; first the goal, then the positions. */
static void draw(double *w, uint64_t seed)
{
    double position[2 * (AGENTS + LANDMARKS)];
    const int goal = (int)(next_bits(&seed) >> 63);
    int i;
    for (i = 0; i < 2 * (AGENTS + LANDMARKS); i++) {
        position[i] = next_coordinate(&seed);
    }
    place(w, goal, position);
}

static void step(double *w, const int *actions)
{
    static const double effect[5][2] = {{0.0, 0.0}, {-1.0, 0.0}, {1.0, 0.0}, {0.0, -1.0}, {0.0, 1.0}};
    int agent, axis;
    for (agent = 0; agent < AGENTS; agent++) {
        for (axis = 0; axis < 2; axis++) {
            double *const p = &w[POSITION(agent) + axis];
            double *const v = &w[VELOCITY(agent) + axis];
            *p = *p + *v * DT;
            *v = *v * (1.0 - DAMPING) + effect[actions[agent]][axis] * FORCE * DT;
        }
    }
}

static int near(const double *w, int agent, int target)
{
    const double dx = w[POSITION(agent)] - w[target], dy = w[POSITION(agent) + 1] - w[target + 1];
    return dx * dx + dy * dy < SQUARED_RADIUS;
}

static Episode play(double *w)
{
    Episode episode = {0, 0, {{0}}};
    int t;
    for (t = 0; t < STEPS; t++) {
        physical_deception_act_team(w, episode.actions[t]);
        step(w, episode.actions[t]);
        episode.adversary |= near(w, 0, PHYSICAL_DECEPTION_W_GOAL_X);
        episode.defenders |= near(w, 1, LANDMARK(0)) && near(w, 2, LANDMARK(1));
        episode.defenders |= near(w, 1, LANDMARK(1)) && near(w, 2, LANDMARK(0));
    }
    return episode;
}

/* Reads a start; 0 where the line is none. */
static int parse(double *w, const char *line)
{
    double position[2 * (AGENTS + LANDMARKS)];
    char *end;
    const long goal = strtol(line, &end, 10);
    int i;
    if (end == line || goal < 0 || goal >= LANDMARKS) {
        return 0;
    }
    for (i = 0; i < 2 * (AGENTS + LANDMARKS); i++) {
        const char *const from = end;
        position[i] = strtod(from, &end);
        if (end == from || !(position[i] >= -DBL_MAX && position[i] <= DBL_MAX)) {
            return 0;
        }
    }
    place(w, (int)goal, position);
    return end[strspn(end, " \t\r\n")] == '\0';
}

static int fail(const char *what, const char *where)
{
    fprintf(stderr, "simulation: %s: %s\n", what, where);
    return 2;
}

static void count(double *w, int each, long *counts)
{
    const Episode episode = play(w);
    int t, i;
    counts[0]++;
    counts[1] += episode.adversary;
    counts[2] += episode.defenders;
    if (each) {
        printf("%d %d", episode.adversary, episode.defenders);
        for (t = 0; t < STEPS; t++) {
            printf(" %d%d%d", episode.actions[t][0], episode.actions[t][1], episode.actions[t][2]);
        }
        for (i = 0; i < 2 * AGENTS; i++) {
            printf(" %.17g", w[POSITION(0) + i]);
        }
        printf("\n");
    }
}

static int play_file(const Options *options, long *counts)
{
    char line[LONGEST_LINE];
    double w[PHYSICAL_DECEPTION_N_COORDINATES];
    FILE *const file = fopen(options->starts, "r");
    if (!file) {
        return fail(strerror(errno), options->starts);
    }
    while (fgets(line, sizeof line, file)) {
        if (!parse(w, line)) {
            char start[32];
            snprintf(start, sizeof start, "line %ld", counts[0] + 1);
            fclose(file);
            return fail("no start (goal 0 or 1, then ten finite numbers)", start);
        }
        count(w, options->each, counts);
    }
    fclose(file);
    return counts[0] ? 0 : fail("no starts", options->starts);
}

static int play_drawn(const Options *options, long *counts)
{
    long i;
    for (i = 0; i < options->episodes; i++) {
        double w[PHYSICAL_DECEPTION_N_COORDINATES];
        draw(w, options->seed + (uint64_t)i);
        count(w, options->each, counts);
    }
    return 0;
}

static int read_options(Options *options, int argc, char **argv)
{
    int i;
    for (i = 1; i < argc; i++) {
        const char *const option = argv[i], *const value = i + 1 < argc ? argv[i + 1] : "";
        const int natural = value[0] != '\0' && value[strspn(value, "0123456789")] == '\0';
        if (strcmp(option, "--each") == 0) {
            options->each = 1;
            continue;
        }
        errno = 0;
        if (strcmp(option, "--starts") == 0) {
            options->starts = value;
        } else if (strcmp(option, "--episodes") == 0 && natural) {
            options->episodes = strtol(value, NULL, 10);
        } else if (strcmp(option, "--seed") == 0 && natural) {
            options->seed = strtoull(value, NULL, 10);
        } else {
            return fail("unknown option, or no number behind it", option);
        }
        if (errno == ERANGE || options->episodes < 1) {
            return fail("a number that does not fit", option);
        }
        i++;
    }
    return 0;
}

int main(int argc, char **argv)
{
    Options options = {10000, 0, NULL, 0};
    long counts[3] = {0, 0, 0};
    int failed = read_options(&options, argc, argv), team;
    if (!failed) {
        failed = options.starts ? play_file(&options, counts) : play_drawn(&options, counts);
    }
    for (team = 1; team < 3 && !failed; team++) {
        printf("%s success r=0.316: %ld of %ld episodes, %.3f\n", team == 1 ? "adversaries" : "defenders", counts[team],
               counts[0], (double)counts[team] / (double)counts[0]);
    }
    return failed;
}
