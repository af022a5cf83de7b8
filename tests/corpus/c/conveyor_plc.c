#include <stdbool.h>

/* converted from structured text */
enum { STOP = 0, FWD = 1, REV = 2, BRAKE = 3 };

int conveyor(bool start_pb, bool stop_pb, bool e_stop, bool overload, bool jam_sensor, float belt_speed)
{
    bool permit, fault, run, reverse;

    permit = !stop_pb && !e_stop;
    fault = overload || jam_sensor;
    run = start_pb && permit && !fault;
    reverse = jam_sensor && permit && (belt_speed < 0.1f);

    if (e_stop) return BRAKE;
    if (run) return FWD;
    if (reverse) return REV;
    return STOP;
}
