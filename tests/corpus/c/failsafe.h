#pragma once

#include <stdbool.h>

enum failsafe_action {
	FS_NONE = 0,
	FS_WARN,
	FS_HOLD,
	FS_RTL,
	FS_LAND,
};

struct vehicle_status {
	float battery_remaining;
	float home_distance;
	bool rc_lost;
	bool in_mission;
	bool gps_ok;
};

enum failsafe_action failsafe_select(const struct vehicle_status *status);
