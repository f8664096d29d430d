#include "host/link/can_control.h"

#include <linux/errqueue.h>
#include <string.h>
#include <time.h>

#include "common/catalogue.h"

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

size_t can_board_filters(struct can_filter *filters, size_t most)
{
    size_t count = 0;
    for (uint16_t id = 0; id <= CAN_SFF_MASK && count < most; id++) {
        const struct mr_message_info *info = mr_message_find(id);
        if (info && info->length <= CAN_MAX_DLEN)
            filters[count++] = (struct can_filter){
                .can_id = id, .can_mask = CAN_SFF_MASK | CAN_EFF_FLAG | CAN_RTR_FLAG};
    }
    return count;
}
