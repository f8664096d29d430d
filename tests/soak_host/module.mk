# A full bus into one campaign.
$(B)/tests/soak_host/sender: $(B)/tests/soak_host/sender.o $(B)/host/hil/periph/canbits.o $(B)/host/host/link/candump.o $(common_lib)
	$(call link,-lm)
test-programs: $(B)/tests/soak_host/sender

.PHONY: soak-host
soak-host: $(B)/tests/soak_host/sender $(B)/matrig ## longer | HOURS=1 or SECONDS=: a full CAN bus and 2 Mbaud into one campaign: lost, memory, processor
	@mkdir -p $(B)/soak_host
	@tests/soak_host/run.sh $(or $(SECONDS),$(shell echo $$(($(or $(HOURS),1) * 3600)))) $(B)/soak_host | tee $(B)/soak_host/summary.txt
