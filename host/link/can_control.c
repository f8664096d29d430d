#include "host/link/can_control.h"

#include <linux/errqueue.h>
#include <string.h>
#include <time.h>

#include "common/canbase.h"

static uint64_t microseconds(const struct timespec *at)
{
    return (uint64_t)at->tv_sec * 1000000u + (uint64_t)at->tv_nsec / 1000u;
}

void can_control_take(struct msghdr *message, struct can_control *control)
{
    *control = (struct can_control){0};
    for (struct cmsghdr *c = CMSG_FIRSTHDR(message); c; c = CMSG_NXTHDR(message, c)) {
        size_t length = c->cmsg_len - CMSG_LEN(0);
        if (c->cmsg_level != SOL_SOCKET)
            continue;
        if (c->cmsg_type == SO_TIMESTAMPNS && length >= sizeof(struct timespec)) {
            struct timespec at;
            memcpy(&at, CMSG_DATA(c), sizeof at);
            control->kernel_us = microseconds(&at);
        } else if (c->cmsg_type == SO_TIMESTAMPING && length >= sizeof(struct scm_timestamping)) {
            struct scm_timestamping at; /* by the kernel; no longer used; by the hardware */
            memcpy(&at, CMSG_DATA(c), sizeof at);
            control->kernel_us = microseconds(&at.ts[0]);
            control->hardware_us = microseconds(&at.ts[2]);
        } else if (c->cmsg_type == SO_RXQ_OVFL && length >= sizeof control->lost) {
            memcpy(&control->lost, CMSG_DATA(c), sizeof control->lost);
            control->lost_known = true;
        }
    }
}

size_t can_board_filters(const struct link_bases *bases, struct can_filter *filters, size_t most)
{
    size_t messages, count = 0;
    const struct mr_message_info *info = mr_catalogue(&messages);
    for (size_t i = 0; i < bases->count * messages && count < most; i++)
        filters[count++] = (struct can_filter){
            .can_id = mr_can_to_bus(info[i % messages].id, bases->base[i / messages]),
            .can_mask = CAN_SFF_MASK | CAN_EFF_FLAG | CAN_RTR_FLAG};
    return count;
}
