# SPDX-License-Identifier: MIT OR Apache-2.0
"""Stiffness of hexahedral meshes with scikit-fem: linear elements, with or without incompatible modes."""

import numpy as np
from skfem import Basis, BilinearForm, ElementHex1, ElementVector, MeshHex
from skfem.element import DiscreteField
from skfem.helpers import ddot, eye, sym_grad, trace
from skfem.models.elasticity import lame_parameters

# scikit-fem's order of the corners, as positions in ours.
CORNERS = [6, 2, 5, 7, 1, 3, 4, 0]


class Bubble(ElementHex1):
    """Three incompatible modes s (1 - s), one per direction, after Taylor, Beresford and Wilson (1976).

    Linear hexahedra are too stiff in bending; with these modes, which end at the element, they are not. The gradients
    are mapped with the Jacobian of the centre, so that a constant stress does no work on them: the patch test holds for
    any shape."""

    nodal_dofs = 0
    interior_dofs = 3
    dofnames = ["b"] * 3
    doflocs = np.full((3, 3), 0.5)

    def gbasis(self, mapping, X, i, tind=None):
        centre = np.full((3, 1), 0.5)
        scale = mapping.detDF(centre, tind) / mapping.detDF(X, tind)
        slope = np.zeros_like(X)
        slope[i] = 1 - 2 * X[i]
        grad = np.einsum("ijk,il->jkl", mapping.invDF(centre, tind)[..., 0], slope) * scale
        return (DiscreteField(value=np.broadcast_to(X[i] * (1 - X[i]), grad.shape[1:]), grad=grad),)


def stiffness(mesh, young, poisson, incompatible=True):
    """Sparse stiffness matrix; degree of freedom 3 n + c is component c of node n."""
    lame, shear = lame_parameters(young, poisson)

    @BilinearForm
    def energy(u, v, _):
        strain = sym_grad(u)
        return ddot(2 * shear * strain + eye(lame * trace(strain), 3), sym_grad(v))

    skmesh = MeshHex(np.ascontiguousarray(mesh.points.T), np.ascontiguousarray(mesh.hexahedra.T[CORNERS]))
    nodal = Basis(skmesh, ElementVector(ElementHex1()), intorder=2)
    form = energy.coo_data(nodal)
    if incompatible:
        # The modes carry no load and are eliminated element by element.
        modes = Basis(skmesh, ElementVector(Bubble()), quadrature=nodal.quadrature)

        def local(trial, test):
            data = energy.coo_data(trial, test).data.reshape(trial.Nbfun, test.Nbfun, -1)
            return np.moveaxis(data, -1, 0)  # [element, trial, test]

        coupling = local(modes, nodal)
        form = form.fromlocal(form.tolocal() - coupling.mT @ np.linalg.solve(local(modes, modes), coupling))
    return form.tocsr()
