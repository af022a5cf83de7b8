/**
 * @file elevator_llm.c
 * @brief Simple rule-based elevator controller.
 */
#include <stdio.h>
#include <stdbool.h>

#define MAX_LOAD_KG 630
#define NUM_TESTS 3

typedef enum {
    ACTION_IDLE,
    ACTION_MOVE_UP,
    ACTION_MOVE_DOWN,
    ACTION_OPEN_DOOR,
    NUM_ACTIONS
} ElevatorAction;

typedef struct {
    int current_floor;
    int load_kg;
    bool call_above;
    bool call_below;
    bool call_here;
} ElevatorState;

/* Human-readable names for the actions */
static const char *ACTION_NAMES[NUM_ACTIONS] = {
    "IDLE", "MOVE_UP", "MOVE_DOWN", "OPEN_DOOR"
};

/**
 * @brief Decide on the next action.
 * @param state Pointer to the current state (must not be NULL).
 * @return The chosen action.
 */
ElevatorAction elevator_decide(const ElevatorState *state) {
    if (state == NULL) {
        return ACTION_IDLE;
    }

    // Safety first: never move when overloaded
    if (state->load_kg > MAX_LOAD_KG) {
        return ACTION_OPEN_DOOR;
    }

    if (state->call_here) {
        return ACTION_OPEN_DOOR;
    } else if (state->call_above && state->current_floor < 12) {
        return ACTION_MOVE_UP;
    } else if (state->call_below && state->current_floor > 0) {
        return ACTION_MOVE_DOWN;
    }

    return ACTION_IDLE;
}

static void print_decision(const ElevatorState *state) {
    printf("floor %d, load %d -> %s\n", state->current_floor, state->load_kg,
           ACTION_NAMES[elevator_decide(state)]);
}

int main(void) {
    ElevatorState tests[NUM_TESTS] = {
        { .current_floor = 0, .load_kg = 100, .call_above = true },
        { 5, 700, false, false, true },
        { 3, 0, false, true, false },
    };

    for (int i = 0; i < NUM_TESTS; i++) {
        print_decision(&tests[i]);
    }
    return 0;
}
