/* stop if the kinetic energy exceeds what the remaining track can absorb */
#define MASS 1200.0
#define FORCE 5400.0

int must_brake(double v, double track)
{
    double energy = 0.5 * MASS * v * v;
    return energy > FORCE * track;
}
