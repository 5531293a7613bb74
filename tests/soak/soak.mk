# Measurements that take long: random frames against the exact engine, and
# differences between processors. Both need python3 with numpy and OpenImageIO.

SEED ?= 1
SOAK_FRAMES = $(if $(filter file,$(origin FRAMES)),2000,$(FRAMES))
PYTHON ?= /usr/bin/python3

.PHONY: soak determinism

soak: $(B)/glarepp $(BRIDGES) ## compares random frames and options with --engine direct: SEED=1 FRAMES=2000 [ONLY=case]
	@$(PYTHON) tests/soak/soak.py $(B)/glarepp --seed $(SEED) \
	    --frames $(SOAK_FRAMES) --folder $(B)/soak $(if $(ONLY),--only $(ONLY))

determinism: $(B)/glarepp $(BRIDGES) ## measures differences between processors and build folders
	@tests/soak/twin.sh $(B)
	@$(PYTHON) tests/soak/families.py $(B)/glarepp $(B)/families
