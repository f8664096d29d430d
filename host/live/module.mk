# The live page: uPlot of the version and checksum in package-lock.json, carried by matrig as bytes.
# Where npm's packages lie.
NPM ?= $(B)
uplot := $(NPM)/npm/node_modules/uplot/dist/uPlot.iife.min.js
$(uplot): host/live/page/package.json host/live/page/package-lock.json host/live/page/fetch.sh | $(B)/.demo-packages
	@sh host/live/page/fetch.sh $(NPM)/npm
	@touch $@
$(B)/host/host/live/assets.o: $(uplot) $(wildcard host/live/page/live.* host/live/page/day.*)
$(B)/host/host/live/assets.o: HOST_FLAGS += -Wa,-I$(NPM)/npm
