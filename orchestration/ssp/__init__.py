"""System Structure and Parameterization (SSP) 1.0 and 2.0: systems from `.ssp` files and into them."""

from orchestration.ssp.read import SspFile, read_ssp
from orchestration.ssp.write import write_ssp

__all__ = ["SspFile", "read_ssp", "write_ssp"]
