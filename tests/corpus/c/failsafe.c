/**
 * Failsafe selection. Order of the checks is the order of severity.
 */
#include <stdbool.h>
#include <stddef.h>
#include "failsafe.h"

#define BATT_EMERGENCY 0.05f
#define BATT_CRITICAL  0.10f
#define BATT_LOW       0.20f

static enum failsafe_action worse(enum failsafe_action a, enum failsafe_action b)
{
	return a > b ? a : b;
}

enum failsafe_action failsafe_select(const struct vehicle_status *status)
{
	enum failsafe_action action = FS_NONE;

	if (status->battery_remaining < BATT_EMERGENCY) {
		action = worse(action, FS_LAND);

	} else if (status->battery_remaining < BATT_CRITICAL) {
		action = worse(action, FS_RTL);

	} else if (status->battery_remaining < BATT_LOW) {
		action = worse(action, FS_WARN);
	}

	if (status->rc_lost && !status->in_mission) {
		action = worse(action, status->gps_ok ? FS_RTL : FS_LAND);
	}

	if (status->home_distance > 500.f) {
		action = worse(action, FS_HOLD);
	}

	return action;
}
