/* A clock that nobody sets: for how long things take and when waits end. */
#ifndef MATRIG_HOST_BASE_STEADY_H
#define MATRIG_HOST_BASE_STEADY_H

/* Since some time that is the same for all of a process. */
double steady_s(void);

#endif
