static double filtered = 0.0;

int alarm(double sample)
{
    filtered = 0.9 * filtered + 0.1 * sample;
    return filtered > 75.0;
}
