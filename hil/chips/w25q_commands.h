/* Commands of the W25Q128JV that are modelled: data sheet rev. F, 8.1.2. */
#ifndef MATRIG_HIL_W25Q_COMMANDS_H
#define MATRIG_HIL_W25Q_COMMANDS_H

enum command {
    WRITE_STATUS_1 = 0x01,
    PAGE_PROGRAM = 0x02,
    READ = 0x03,
    WRITE_DISABLE = 0x04,
    READ_STATUS_1 = 0x05,
    WRITE_ENABLE = 0x06,
    FAST_READ = 0x0b,
    WRITE_STATUS_3 = 0x11,
    READ_STATUS_3 = 0x15,
    ERASE_4K = 0x20,
    WRITE_STATUS_2 = 0x31,
    READ_STATUS_2 = 0x35,
    UNIQUE_ID = 0x4b,
    VOLATILE_ENABLE = 0x50,
    ERASE_32K = 0x52,
    ERASE_ALL_60 = 0x60,
    ENABLE_RESET = 0x66,
    MANUFACTURER_ID = 0x90,
    RESET = 0x99,
    JEDEC_ID = 0x9f,
    RELEASE = 0xab,
    POWER_DOWN = 0xb9,
    ERASE_ALL = 0xc7,
    ERASE_64K = 0xd8,
};

#endif
