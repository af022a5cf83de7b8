/* float inputs against double literals: 0.1 is not 0.1f */
int grip(float force, float slip)
{
    if (slip > 0.1)
        return 2;
    if (force < 0.3f)
        return 1;
    if (force == 0.5 || (double) force >= 12.7)
        return 3;
    return 0;
}
