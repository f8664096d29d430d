# Drawn boards on the emulated rig. Of the host only the straight line of matrig calibrate: what links Unicorn links nothing of libserialport.
electronics_parts := $(patsubst %,$(B)/host/%.o,firmware/config host/calibrate/fit host/base/statistics host/base/error)
$(B)/tests/hil/test_electronics: $(electronics_parts)
