/* line follower, three reflectance sensors */
#define BLACK(s) ((s) > THRESH)
enum { THRESH = 512 };
enum motion { GO, SOFT_LEFT, SOFT_RIGHT, HARD_LEFT, HARD_RIGHT, LOST };

enum motion follow(const unsigned short sensor[3])
{
    int pattern = 0;

    if (BLACK(sensor[0])) pattern |= 4;
    if (BLACK(sensor[1])) pattern |= 2;
    if (BLACK(sensor[2])) pattern |= 1;

    switch (pattern) {
        case 2:
        case 7: return GO;
        case 6: return SOFT_LEFT;
        case 3: return SOFT_RIGHT;
        case 4: return HARD_LEFT;
        case 1: return HARD_RIGHT;
        default: return LOST;
    }
}
