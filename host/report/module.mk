# The report's page: its script, carried by matrig as bytes, without what only its reader needs.
closer := $(B)/report/closer.js
$(closer): host/report/closer.js
	@mkdir -p $(@D)
	$(call say,GEN,$@)sed -e 's/^ *//' -e '/^\/\*.*\*\/$$/d' -e '/^\/\*/,/\*\/$$/d' $< >$@
$(B)/host/host/report/closer.o: $(closer)
$(B)/host/host/report/closer.o: HOST_FLAGS += -Wa,-I$(B)/report
