/* whole degrees only, as the display shows them */
unsigned char comfort(float temp, double humidity)
{
    int deg = (int) temp;
    int hum = humidity;

    if (deg < 18 || deg > 26)
        return 0;
    if (hum >= 60)
        return 1;
    return 2;
}
