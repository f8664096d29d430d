# matrig and matrig-board for a Raspberry Pi beside the runway (64-bit ARM), built here and run under QEMU beside the ones of this
# computer. matrig-study stays out: its libraries bring 200 MB of others.
AARCH64_PACKAGES := $(TEST_PACKAGES) gcc-aarch64-linux-gnu qemu-user-static
AARCH64_LIBRARIES := libsqlite3-dev libjansson-dev libserialport-dev libmd-dev libmicrohttpd-dev libc6-dev libunicorn-dev
sysroot := $(B)/aarch64/sysroot

$(B)/.aarch64-packages: $(B)/.test-packages
	$(call install_packages,$(AARCH64_PACKAGES))
$(sysroot)/.made: tests/aarch64/sysroot.sh | $(B)/.aarch64-packages
	@tests/aarch64/sysroot.sh $(sysroot) $(AARCH64_LIBRARIES)

.PHONY: test-aarch64
test-aarch64: in-build all $(B)/tests/conformance/images/places.elf $(sysroot)/.made ## tests | matrig and matrig-board for a Raspberry Pi: cross build, outputs equal to this computer's byte by byte
	@$(MAKE) -s B=$(B)/aarch64 CC="aarch64-linux-gnu-gcc --sysroot=$(CURDIR)/$(sysroot)" BUILD_CC="$(CC)" CFLAGS=-O2 WERROR=-Werror \
		$(B)/aarch64/matrig $(B)/aarch64/matrig-board
	@tests/run-all.sh tests/aarch64/compare.sh
