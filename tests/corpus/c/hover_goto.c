#include <float.h>
#include <stdbool.h>
#include <stdio.h>

#ifdef DEBUG
#define LOG(...) fprintf(stderr, __VA_ARGS__)
#else
#define LOG(...)
#endif

typedef struct obs_s {
	float z, vz;
	struct { float x, y; } err;
} obs_s;

static bool within(float v, float lim)
{
	return v > -lim && v < lim;
}

int hover(obs_s const *o)
{
	int ret;

	LOG("z=%f\n", o->z);
	if (o->z < .2f) {
		ret = 0;
		goto out;
	}
	if (o->vz < -.5f) {
		ret = 1;
		goto out;
	}
	ret = within(o->err.x, .1f) && within(o->err.y, .1f) ? 2 : 3;
out:
	return ret;
}
