/* Units of physical time, in picoseconds. */
#ifndef MATRIG_HIL_TIME_H
#define MATRIG_HIL_TIME_H

#define HIL_SECOND_PS 1000000000000ull
#define HIL_MS_PS     1000000000ull
#define HIL_US_PS     1000000ull
#define HIL_NS_PS     1000ull

#endif
