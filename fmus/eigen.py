"""What of Eigen the FMUs of this project's components do without: two fifths of it, which no law here has a use for.

Laws work on vectors and matrices of a few elements, whose sizes are known. Eigen's kernels for large ones, its solvers,
and views that no law takes are mere ballast in `sources/`: templates that are never made use of, so that the object is
the same without them. `tests/platforms` builds all components from what is left, by another compiler, and
`tests/fmus` compares objects. A law that needs one of these headers does not compile or link there: take it off the
list.
Of a name that another version of Eigen does not have, nothing comes. FMUs of headers from elsewhere, which may use
anything, have all of Eigen/Core and Eigen/LU.
"""

from __future__ import annotations

from pathlib import Path

from fmus.paths import EIGEN

UNUSED: frozenset[Path] = frozenset(
    EIGEN / "Eigen" / "src" / name
    for name in (
        "Core/ArithmeticSequence.h",
        "Core/Array.h",
        "Core/ArrayBase.h",
        "Core/ArrayWrapper.h",
        "Core/BandMatrix.h",
        "Core/BooleanRedux.h",
        "Core/ConditionEstimator.h",
        "Core/CoreIterators.h",
        "Core/CwiseTernaryOp.h",
        "Core/CwiseUnaryView.h",
        "Core/Fuzzy.h",
        "Core/IndexedView.h",
        "Core/NestByValue.h",
        "Core/NoAlias.h",
        "Core/PermutationMatrix.h",
        "Core/Random.h",
        "Core/Ref.h",
        "Core/Replicate.h",
        "Core/Reshaped.h",
        "Core/Reverse.h",
        "Core/Select.h",
        "Core/SelfAdjointView.h",
        "Core/SelfCwiseBinaryOp.h",
        "Core/Solve.h",
        "Core/SolveTriangular.h",
        "Core/SolverBase.h",
        "Core/StableNorm.h",
        "Core/StlIterators.h",
        "Core/Swap.h",
        "Core/Transpositions.h",
        "Core/TriangularMatrix.h",
        "Core/Visitor.h",
        "Core/arch/Default/GenericPacketMathFunctions.h",
        "Core/arch/Default/GenericPacketMathFunctionsFwd.h",
        "Core/arch/Default/TypeCasting.h",
        "Core/functors/TernaryFunctors.h",
        "Core/products/GeneralBlockPanelKernel.h",
        "Core/products/GeneralMatrixMatrix.h",
        "Core/products/GeneralMatrixMatrixTriangular.h",
        "Core/products/GeneralMatrixVector.h",
        "Core/products/Parallelizer.h",
        "Core/products/SelfadjointMatrixMatrix.h",
        "Core/products/SelfadjointMatrixVector.h",
        "Core/products/SelfadjointProduct.h",
        "Core/products/SelfadjointRank2Update.h",
        "Core/products/TriangularMatrixMatrix.h",
        "Core/products/TriangularMatrixVector.h",
        "Core/products/TriangularSolverMatrix.h",
        "Core/products/TriangularSolverVector.h",
        "Core/util/IndexedViewHelper.h",
        "Core/util/MKL_support.h",
        "Core/util/ReshapedHelper.h",
        "Core/util/SymbolicIndex.h",
        "LU/FullPivLU.h",
        "LU/PartialPivLU.h",
        "misc/Image.h",
        "misc/Kernel.h",
        "plugins/ArrayCwiseBinaryOps.h",
        "plugins/ArrayCwiseUnaryOps.h",
        "plugins/IndexedViewMethods.h",
        "plugins/ReshapedMethods.h",
    )
)
"""Headers that are left out where others include them."""
