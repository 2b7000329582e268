# SPDX-License-Identifier: MIT OR Apache-2.0
"""Elastic bodies and contact pairs distributed over ranks: dolfinx assembles, PETSc holds vectors and matrices.

The unknowns x are the displacements u of all nodes but for those that are given: u = E x + u_given, where E is the
identity with empty rows for displacements that are given and one column for all that are tied. The places of x that
have no unknown are zero. Residual and Jacobian are E^T R(u) and E^T R'(u) E, with the places filled by a diagonal."""

from mpi4py import MPI  # before dolfinx: it brings the MPI library

import basix.ufl
import dolfinx
import dolfinx.fem.petsc
import numpy as np
import ufl
from petsc4py import PETSc

from models import ROOT

JIT = {"cache_dir": ROOT / "build/mpi-jit"}  # compiled forms
TENSOR_ORDER = [0, 1, 3, 2, 4, 5, 7, 6]  # of a hexahedron's nodes in dolfinx, as places in VTK's order


class Structure:
    """The bodies of a model on the ranks of a communicator, without the law.

    Collective unless said otherwise. `own` arrays are those of this rank."""

    def __init__(self, comm, model):
        self.comm, self.model = comm, model
        self._mesh()
        self._pairs()
        self._constraints()
        self._matrices()

    # --- numbers ------------------------------------------------------------------------------------------------------

    def _mesh(self):
        model, first = self.model, self.comm.rank == 0
        points = model.points if first else np.empty((0, 3))
        cells = model.hexahedra[:, TENSOR_ORDER] if first else np.empty((0, 8), np.int64)
        element = basix.ufl.element("Lagrange", "hexahedron", 1, shape=(3,))
        self.mesh = dolfinx.mesh.create_mesh(self.comm, cells, ufl.Mesh(element), points)
        self.space = dolfinx.fem.functionspace(self.mesh, ("Lagrange", 1, (3,)))
        blocks, nodes = self.space.dofmap.index_map, self.mesh.geometry.input_global_indices
        self.own_nodes = np.empty(blocks.size_local + blocks.num_ghosts, np.int64)  # input number of each block
        self.own_nodes[self.space.dofmap.list.ravel()] = nodes[self.mesh.geometry.dofmaps[0].ravel()]
        self.own_nodes = self.own_nodes[:blocks.size_local]
        self.first_block, self.nodes = blocks.local_range[0], blocks.size_global
        self._order = np.argsort(self.own_nodes)

    def find(self, nodes):
        """Which of the nodes (input numbers) this rank owns: their places in `nodes`, and their own blocks. Local."""
        nodes = np.asarray(nodes)
        if not len(self.own_nodes):
            return np.empty(0, int), np.empty(0, int)
        at = np.searchsorted(self.own_nodes, nodes, sorter=self._order).clip(max=len(self._order) - 1)
        block = self._order[at]
        places = np.flatnonzero(self.own_nodes[block] == nodes)
        return places, block[places]

    def global_blocks(self, nodes):
        """Global block number of each node, on every rank: each fills in its own, the largest wins."""
        blocks = np.full(len(nodes), -1, np.int64)
        places, own = self.find(nodes)
        blocks[places] = self.first_block + own
        self.comm.Allreduce(MPI.IN_PLACE, blocks, MPI.MAX)
        return blocks

    # --- contact pairs ------------------------------------------------------------------------------------------------

    def _pairs(self):
        """A pair belongs to the rank that owns its lower node. The upper one is often another rank's: the partitioner
        sees no connection between the bodies."""
        pairs = self.model.pairs
        lower, upper = (np.concatenate([getattr(pair, side) for pair in pairs]) for side in ("lower", "upper"))
        area, frame = np.concatenate([p.area for p in pairs]), np.concatenate([p.frame for p in pairs])
        self.pairs = len(lower)  # of all ranks, one numbering for all interfaces
        ends = np.cumsum([len(pair.lower) for pair in pairs])
        self.first_pair = dict(zip((pair.name for pair in pairs), ends - [len(pair.lower) for pair in pairs]))
        self.blocks_lower, self.blocks_upper = self.global_blocks(lower), self.global_blocks(upper)
        places, _ = self.find(lower)
        self.own_pairs = np.sort(places)
        self.own_lower, self.own_upper = lower[self.own_pairs], upper[self.own_pairs]
        self.own_area, self.own_frame = area[self.own_pairs], frame[self.own_pairs]
        # Where the pairs of each interface stand among the own ones.
        cuts = np.searchsorted(self.own_pairs, np.concatenate([[0], ends]))
        self.parts = {pair.name: slice(*cuts[k:k + 2]) for k, pair in enumerate(pairs)}
        self.straddling = int(self.comm.allreduce(
            len(self.own_pairs) - len(self.find(self.own_upper)[0]), MPI.SUM))

    def _dofs_of_pairs(self):
        """Global dofs of the own pairs [pair, 6]: lower x, y, z, upper x, y, z."""
        blocks = np.stack([self.blocks_lower[self.own_pairs], self.blocks_upper[self.own_pairs]], axis=1)
        return (3 * blocks[:, :, None] + np.arange(3)).reshape(-1, 6)

    # --- constraints --------------------------------------------------------------------------------------------------

    def _constraints(self):
        model, size = self.model, 3 * len(self.own_nodes)
        free = np.ones(size, bool)
        column = 3 * self.first_block + np.arange(size)
        self.own_moved = 3 * self.find(model.moved[0])[1] + model.moved[1]
        for nodes, direction in [*model.fixed, model.moved]:
            free[3 * self.find(nodes)[1] + direction] = False
        self.masters = []
        for nodes, direction, _ in model.tied:
            master = np.min(nodes)
            own = 3 * self.find(nodes)[1] + direction
            column[own] = master_dof = 3 * self.global_blocks([master])[0] + direction
            free[own] = False  # but for the master's own place
            if self.first_block * 3 <= master_dof < self.first_block * 3 + size:
                free[master_dof - 3 * self.first_block] = True
            self.masters.append(master_dof)
        given = ~free & (column == 3 * self.first_block + np.arange(size))
        self._free, self._rows = free, (np.flatnonzero(~given), column[~given])

    def _expansion(self, vector):
        """E."""
        matrix = PETSc.Mat().createAIJ((vector.getSizes(), vector.getSizes()), bsize=3, comm=self.comm)
        row, column = self._rows
        index = PETSc.IntType
        matrix.setPreallocationCOO((row + 3 * self.first_block).astype(index), column.astype(index))
        matrix.setValuesCOO(np.ones(len(row)))
        return matrix

    # --- matrices -----------------------------------------------------------------------------------------------------

    def _matrices(self):
        model = self.model
        trial, test = ufl.TrialFunction(self.space), ufl.TestFunction(self.space)
        lame = model.young * model.poisson / ((1 + model.poisson) * (1 - 2 * model.poisson))
        shear = model.young / (2 * (1 + model.poisson))
        strain = ufl.sym(ufl.grad(trial))
        stress = 2 * shear * strain + lame * ufl.tr(strain) * ufl.Identity(3)
        energy = ufl.inner(stress, ufl.sym(ufl.grad(test))) * ufl.dx(metadata={"quadrature_degree": 2})
        self.elastic = dolfinx.fem.petsc.assemble_matrix(dolfinx.fem.form(energy, jit_options=JIT))
        self.elastic.assemble()
        vector = self.elastic.createVecRight()
        self.expand = self._expansion(vector)

        # E^T K E, and a diagonal of the same size for the places without an unknown.
        reduced = self.elastic.PtAP(self.expand)
        diagonal = self.elastic.getDiagonal()
        self.scale = diagonal.sum() / diagonal.getSize()
        self.filler = vector.duplicate()
        self.filler.array = np.where(self._free, 0, self.scale)
        filling = PETSc.Mat().createAIJ(reduced.getSizes(), bsize=3, comm=self.comm)
        own = (3 * self.first_block + np.arange(len(self._free))).astype(PETSc.IntType)
        filling.setPreallocationCOO(own, own)
        filling.setValuesCOO(self.filler.array_r)

        # Contact: a 6 x 6 block for each own pair. Rows of the upper node may be another rank's; PETSc makes a plan for
        # that once. Places without an unknown are left out (negative numbers).
        self._vector = vector
        dofs = self._dofs_of_pairs()
        free = self._free_of(dofs)
        tied = ~free & ~self._given_of(dofs)
        if self.comm.allreduce(bool(tied.any()), MPI.LOR):
            raise ValueError("a tied displacement belongs to a contact pair: only others can be tied")
        dofs_free = np.where(free, dofs, -1)
        row = np.repeat(dofs_free[:, :, None], 6, axis=2).ravel().astype(PETSc.IntType)
        column = np.repeat(dofs_free[:, None, :], 6, axis=1).ravel().astype(PETSc.IntType)
        self.contact = PETSc.Mat().createAIJ(reduced.getSizes(), bsize=3, comm=self.comm)
        self.contact.setPreallocationCOO(row, column)
        self.contact.setValuesCOO(np.zeros(row.size))

        # The elastic part in the pattern of the whole: copied in each iteration, then contact is added.
        different = PETSc.Mat.Structure.DIFFERENT_NONZERO_PATTERN
        reduced.axpy(1, filling, different)
        reduced.axpy(1, self.contact, different)
        reduced.setBlockSize(3)
        reduced.setOption(PETSc.Mat.Option.NEW_NONZERO_LOCATION_ERR, True)
        self.reduced = reduced
        self.jacobian = reduced.duplicate(copy=True)

        # One scatter, used forward for displacements and backward for forces.
        index = PETSc.IS().createGeneral(dofs.ravel().astype(PETSc.IntType), comm=PETSc.COMM_SELF)
        self._of_pairs = PETSc.Vec().createSeq(dofs.size, comm=PETSc.COMM_SELF)
        self.scatter = PETSc.Scatter().create(vector, index, self._of_pairs, None)

    def _flags_of(self, own, dofs):
        """A flag of each global dof of `dofs`, given the own ones; the interface is small enough to ask all ranks."""
        nodes = np.unique(np.concatenate([self.blocks_lower, self.blocks_upper]))
        flags = np.zeros((len(nodes), 3), np.int8)
        here = (nodes >= self.first_block) & (nodes < self.first_block + len(self.own_nodes))
        flags[here] = own.reshape(-1, 3)[nodes[here] - self.first_block]
        self.comm.Allreduce(MPI.IN_PLACE, flags, MPI.MAX)
        return flags[np.searchsorted(nodes, dofs // 3), dofs % 3].astype(bool)

    def _free_of(self, dofs):
        return self._flags_of(self._free, dofs)

    def _given_of(self, dofs):
        given = np.ones(len(self._free), bool)
        given[self._rows[0]] = False
        return self._flags_of(given, dofs)

    # --- what the solver asks for -------------------------------------------------------------------------------------

    def vector(self):
        return self._vector.duplicate()

    def displacement(self, x, moved):
        """u of the unknowns and of the displacement of the moved nodes."""
        u = self.expand.createVecLeft()
        self.expand.mult(x, u)
        u.array[self.own_moved] = moved
        return u

    def to_pairs(self, u):
        """Displacements of the own pairs [pair, lower and upper, component]."""
        self.scatter.begin(u, self._of_pairs)
        self.scatter.end(u, self._of_pairs)
        return self._of_pairs.array_r.reshape(-1, 2, 3).copy()

    def from_pairs(self, forces, vector):
        """Adds forces on the nodes of the own pairs to a vector, also where another rank has the node."""
        self._of_pairs.array = forces.ravel()
        self.scatter.begin(self._of_pairs, vector, PETSc.InsertMode.ADD, PETSc.ScatterMode.REVERSE)
        self.scatter.end(self._of_pairs, vector, PETSc.InsertMode.ADD, PETSc.ScatterMode.REVERSE)

    def assemble(self, blocks, matrix):
        """The Jacobian: elastic, and the blocks [pair, 6, 6] of the own pairs."""
        self.contact.setValuesCOO(blocks.ravel())
        self.reduced.copy(matrix, PETSc.Mat.Structure.SAME_NONZERO_PATTERN)
        matrix.axpy(1, self.contact, PETSc.Mat.Structure.SUBSET_NONZERO_PATTERN)

    def rigid_motions(self):
        """The six motions that cost an elastic body nothing: what algebraic multigrid has to know."""
        places = np.empty((len(self.own_nodes), 3))
        geometry = self.mesh.geometry
        numbers = np.empty(geometry.x.shape[0], np.int64)  # block of each of the mesh's own points
        numbers[geometry.dofmaps[0].ravel()] = self.space.dofmap.list.ravel()
        own = numbers < len(places)
        places[numbers[own]] = geometry.x[own]
        motions = []
        for kind in range(6):
            motion = np.zeros_like(places)
            if kind < 3:
                motion[:, kind] = 1
            else:
                i, j = (kind + 1) % 3, (kind + 2) % 3
                motion[:, i], motion[:, j] = -places[:, j], places[:, i]
            motion = motion.ravel() * self._free
            vector = self.vector()
            vector.array = motion
            motions.append(vector)
        return PETSc.NullSpace().create(vectors=self._orthonormal(motions), comm=self.comm)

    def _orthonormal(self, vectors):
        done = []
        for vector in vectors:
            for other in done:
                vector.axpy(-vector.dot(other), other)
            vector.normalize()
            done.append(vector)
        return done

    # --- whole fields by input number: files that do not know the partition ------------------------------------------------

    def gather(self, numbers, rows, total):
        """Own rows [n, width] to rank 0, in the order of their numbers; None elsewhere."""
        width = int(np.prod(rows.shape[1:], dtype=int))
        counts = self.comm.gather(len(numbers))
        first = self.comm.rank == 0
        all_numbers = np.empty(sum(counts), np.int64) if first else None
        all_rows = np.empty((sum(counts), width)) if first else None
        self.comm.Gatherv(np.ascontiguousarray(numbers, np.int64), (all_numbers, counts) if first else None)
        row = MPI.DOUBLE.Create_contiguous(max(width, 1)).Commit()  # counts stay small numbers
        self.comm.Gatherv([np.ascontiguousarray(rows, float), len(numbers), row],
                          [all_rows, counts, None, row] if first else None)
        row.Free()
        if not first:
            return None
        whole = np.empty((total, width))
        whole[all_numbers] = all_rows
        return whole

    def spread(self, numbers, whole, width):
        """Rows of an array on rank 0 to the ranks that ask for their numbers."""
        counts = self.comm.gather(len(numbers))
        first = self.comm.rank == 0
        all_numbers = np.empty(sum(counts), np.int64) if first else None
        self.comm.Gatherv(np.ascontiguousarray(numbers, np.int64), (all_numbers, counts) if first else None)
        rows = np.empty((len(numbers), width))
        row = MPI.DOUBLE.Create_contiguous(max(width, 1)).Commit()
        self.comm.Scatterv([np.ascontiguousarray(whole[all_numbers]), counts, None, row] if first else None,
                           [rows, len(numbers), row])
        row.Free()
        return rows
