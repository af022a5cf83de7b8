// My plant watering thing, v2
// ATtiny85, compiled with avr-gcc
#include <stdio.h>

#define DRY 300
#define WET 700
#define NIGHT 50

#define PUMP_OFF 0
#define PUMP_ON 1
#define PUMP_PULSE 2

int pump(int soil, int light) {
  // adc values are 0..1023
  if (soil < DRY) return PUMP_ON;
  if (light < NIGHT) return PUMP_OFF;   // don't water at night
  if (soil < WET) return PUMP_PULSE;
  return PUMP_OFF;
}

int main(void) {
  int s, l;
  while (scanf("%d %d", &s, &l) == 2) {
    printf("%d\n", pump(s, l));
  }
  return 0;
}
