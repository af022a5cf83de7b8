# translated from ladder logic, rung by rung

def conveyor(start_pb, stop_pb, e_stop, overload, jam_sensor, belt_speed):
    # rung 1: permissives
    permit = not stop_pb and not e_stop
    # rung 2: faults
    fault = overload or jam_sensor
    # rung 3: motor
    run = start_pb and permit and not fault
    # rung 4: reverse to clear a jam
    reverse = jam_sensor and permit and belt_speed < 0.1
    if e_stop:
        return 'BRAKE'
    if run:
        return 'FWD'
    if reverse:
        return 'REV'
    return 'STOP'
