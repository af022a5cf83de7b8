/* whole degrees only, as the display shows them; what the sensor cannot mean is an error */
#define SENSOR_ERROR 3

unsigned char comfort(float temp, double humidity)
{
    int deg, hum;

    if (!(temp > -100.0f && temp < 150.0f) || !(humidity >= 0.0 && humidity <= 100.0))
        return SENSOR_ERROR;
    deg = (int) temp;
    hum = humidity;

    if (deg < 18 || deg > 26)
        return 0;
    if (hum >= 60)
        return 1;
    return 2;
}
