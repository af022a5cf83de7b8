#include <stdlib.h>
#include <stdio.h>
#include <math.h>

#define N_FEATURES 3
#define N_CLASSES 2

int predict(float features[N_FEATURES]) {

    int classes[N_CLASSES];

    if (features[0] <= 6.5) {
        if (features[2] <= 70.3500022888) {
            classes[0] = 112;
            classes[1] = 41;
        } else {
            classes[0] = 23;
            classes[1] = 98;
        }
    } else {
        if (features[1] <= 0.5) {
            classes[0] = 310;
            classes[1] = 12;
        } else {
            classes[0] = 55;
            classes[1] = 56;
        }
    }

    int i, class_idx = 0, class_val = classes[0];
    for (i = 1; i < N_CLASSES; i++) {
        if (classes[i] > class_val) {
            class_idx = i;
            class_val = classes[i];
        }
    }
    return class_idx;
}

int main(int argc, const char * argv[]) {

    /* Features: */
    double features[argc-1];
    int i;
    for (i = 1; i < argc; i++) {
        features[i-1] = atof(argv[i]);
    }

    /* Prediction: */
    float f[N_FEATURES] = { features[0], features[1], features[2] };
    printf("%d", predict(f));
    return 0;
}
