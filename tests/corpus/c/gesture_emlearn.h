

#include <stdint.h>


static inline int32_t gesture_tree_0(const int16_t *features, int8_t features_length) {
          if (features[3] < 120) {
              if (features[0] < -45) {
                  return 2;
              } else {
                  return 0;
              }
          } else {
              if (features[1] < 1024) {
                  return 1;
              } else {
                  return 2;
              }
          }
        }

int32_t gesture_predict(const int16_t *features, int8_t features_length) {

        int32_t votes[3] = {0,};
        int32_t _class = -1;

        _class = gesture_tree_0(features, features_length); votes[_class] += 1;
    
        int32_t most_voted_class = -1;
        int32_t most_voted_votes = 0;
        for (int32_t i=0; i<3; i++) {

            if (votes[i] > most_voted_votes) {
                most_voted_class = i;
                most_voted_votes = votes[i];
            }
        }

        return most_voted_class;
    }
