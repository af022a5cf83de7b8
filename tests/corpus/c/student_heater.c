#include <stdio.h>

float target = 21.5;
float band = 1.0;

char heater(float temp, float outside)
{
    float low, high;
    low = target - band;
    high = target + band;
    if (temp < low)
        return 'H';
    if (temp > high && outside < 30)
        return 'C';
    return '-';
}

int main()
{
    float t, o;
    printf("temp and outside: ");
    scanf("%f %f", &t, &o);
    printf("decision: %c\n", heater(t, o));
    return 0;
}
