# The pages' files, carried by matrig as bytes: dygraphs and its licence as Debian has them, and the project's own.
dygraphs := /usr/share/javascript/dygraphs
dygraphs_licence := /usr/share/doc/libjs-dygraphs/copyright
$(B)/host/host/base/assets.o: $(wildcard host/live/page/*) host/report/charts.js host/report/report.css
$(B)/host/host/base/assets.o: HOST_FLAGS += -Wa,-I$(dygraphs),-I$(dir $(dygraphs_licence))
