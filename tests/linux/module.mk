# Real Linux CAN and serial, in a guest.
$(B)/tests/linux/bridge: $(B)/tests/linux/bridge.o $(B)/host/hil/periph/canbits.o
	$(call link)

.PHONY: test-linux
test-linux: in-build $(B)/.linux-packages all $(B)/tests/linux/bridge ## tests | real Linux CAN and serial, in a QEMU guest: frames sent, received, lost; sweeps through Slurm and GNU parallel
	@tests/run-all.sh tests/linux/slurm.sh
	@tests/linux/run.sh
