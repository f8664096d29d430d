# Landings beyond every rig, each answered with its error or refused with a reason.
.PHONY: extremes
extremes: in-build all ## studies | stiff and soft ground, loads, 2,000 mats, 50 landings: answered with an error, or refused with a reason: build/extremes/extremes.md (10 min)
	@python3 tests/extremes/extremes.py $(B)/matrig host/scenes host/landing_series/series $(B)/extremes
