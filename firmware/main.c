/* Main loop: processes what is ready, supervises the tasks, resets the watchdog's counter, and
 * sleeps until the next interrupt. */
#include "firmware/app.h"
#include "firmware/health.h"

static struct app app;

int main(void)
{
    board_start();
    app_start(&app);
    for (;;) {
        bool progress = app_poll(&app);
        if (board_sleep()) {
            app_supervise(&app);
            progress = true;
        }
        tasks_done(MR_TASK_LOOP);
        if (progress && tasks_are_healthy())
            board_watchdog_feed();
    }
}
