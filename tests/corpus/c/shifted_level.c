unsigned char decide(int sensor, unsigned level)
{
    switch (sensor >> 4) {
    case 0: case 1: return 0;
    case 2: if (level > 100u) return 2; /* fallthrough */
    default: break;
    }
    return level & 1 ? 1 : 3;
}
