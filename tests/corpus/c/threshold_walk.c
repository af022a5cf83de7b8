static const float thr[4] = {0.1f, 0.2f, 0.4f, 0.8f};
int level(float p)
{
    int n = 0;
    while (n < 4 && p >= thr[n]) n++;
    return n;
}
