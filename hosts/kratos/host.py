"""The friction box in Kratos Multiphysics: an unmodified release, the contact law loaded from a shared library.

The contact is made of zero-thickness interface elements of the GeoMechanicsApplication. Three laws:

- memory, penalty: the library (its UMAT), in UPwSmallStrainInterfaceElement2D4N / 3D8N
- coulomb: Kratos' own GeoInterfaceCoulombLawPlaneStrain, in Geo_ULineInterfacePlaneStrainElement2Plus2N (2-D only)
"""

import json
import math
import time
from dataclasses import dataclass, field

import KratosMultiphysics as Kratos
import numpy as np

from box import CRITICAL_SLIP, EXPONENT, FRICTION, NORMAL_STIFFNESS, POISSON, PRESSURE, YOUNG, Box

Kratos.Logger.GetDefaultOutput().SetSeverity(Kratos.Logger.Severity.WARNING)
import KratosMultiphysics.GeoMechanicsApplication  # noqa: E402,F401
import KratosMultiphysics.LinearSolversApplication  # noqa: E402,F401
import KratosMultiphysics.StructuralMechanicsApplication  # noqa: E402,F401
from KratosMultiphysics.python_linear_solver_factory import ConstructSolver  # noqa: E402

DISPLACEMENT = (Kratos.DISPLACEMENT_X, Kratos.DISPLACEMENT_Y, Kratos.DISPLACEMENT_Z)
REACTION = (Kratos.REACTION_X, Kratos.REACTION_Y, Kratos.REACTION_Z)
WATER, WATER_REACTION = Kratos.WATER_PRESSURE, Kratos.REACTION_WATER_PRESSURE
STATE_SIZE = 84  # two directions: the UMAT layout has them in 2-D as well
DISSIPATED = 5  # place of the dissipated energy in the state, counted from 1
TOLERANCE = 1e-10  # of the residual, over the first one of the step
MOST_ITERATIONS = 100

# The interface elements are made for wet soil. With the water pressure fixed to zero none of this has an effect.
DRY = {
    "GEO_DRAINAGE_TYPE": "CONSTANT_PW_FIELD", "RETENTION_LAW": "SaturatedLaw", "SATURATED_SATURATION": 1.0,
    "BIOT_COEFFICIENT": 1.0, "POROSITY": 0.3, "TRANSVERSAL_PERMEABILITY": 1e-9, "DYNAMIC_VISCOSITY": 1e-3,
    "BULK_MODULUS_FLUID": 1e9, "BULK_MODULUS_SOLID": 1e9, "DENSITY_WATER": 1.0, "DENSITY_SOLID": 1.0,
    "MINIMUM_JOINT_WIDTH": 1e-3, "YOUNG_MODULUS": 1.0, "POISSON_RATIO": 0.0,
}


def umat_parameters(method):
    """PROPS: the twenty common ones (0: the default), then layout 1 (six slots) and scale 2 (the law sees half the jump).

    The reference pressure is the mean one: the critical slip is the given one there, and no pulsing pressure moves a
    sticking contact."""
    common = [FRICTION, CRITICAL_SLIP, EXPONENT[method], 0, PRESSURE, 0, NORMAL_STIFFNESS] + 13 * [0]
    return [float(value) for value in common + [1, 2]]


def contact_material(dim, method, library, parameters=None, states=STATE_SIZE, pressure=PRESSURE):
    """The law's entry of a materials file. `pressure`: the mean, which the stiffness of Kratos' own law is made for."""
    if method == "coulomb":
        # The law limits the shear by sin(GEO_FRICTION_ANGLE) times the pressure, not by the tangent.
        name = "GeoInterfaceCoulombLawPlaneStrain"
        variables = {
            "GEO_FRICTION_ANGLE": math.degrees(math.asin(FRICTION)), "GEO_COHESION": 0.0, "GEO_DILATANCY_ANGLE": 0.0,
            "INTERFACE_NORMAL_STIFFNESS": NORMAL_STIFFNESS,
            "INTERFACE_SHEAR_STIFFNESS": FRICTION * pressure / CRITICAL_SLIP,
        }
    else:
        name = f"SmallStrainUMAT{dim}DInterfaceLaw"
        variables = {
            "UDSM_NAME": str(library), "IS_FORTRAN_UDSM": True,
            "UMAT_PARAMETERS": umat_parameters(method) if parameters is None else parameters,
            "STATE_VARIABLES": [0.0] * states,
        }
    return {"constitutive_law": {"name": name}, "Variables": DRY | variables}


def interface_element(dim, method):
    if method == "coulomb":
        return "Geo_ULineInterfacePlaneStrainElement2Plus2N"
    return "UPwSmallStrainInterfaceElement" + ("2D4N" if dim == 2 else "3D8N")


@dataclass
class Record:
    """What a run gives, one row per step."""

    displacement: list = field(default_factory=list)
    force: list = field(default_factory=list)  # along the direction of the motion
    normal: list = field(default_factory=list)
    dissipated: list = field(default_factory=list)  # as the law's state has it, all points
    iterations: list = field(default_factory=list)
    seconds: float = 0.0

    def columns(self):
        return {
            "displacement": self.displacement, "force": self.force, "normal_force": self.normal,
            "dissipated_energy": self.dissipated, "iterations": self.iterations,
        }


class NotConverged(RuntimeError):
    """A step for which the iterations ran out; nothing of it has been committed."""


class Model:
    """The box, ready to be moved."""

    def __init__(self, box: Box, method, library, most_iterations=MOST_ITERATIONS, **material):
        self.box, self.method = box, method
        self.model = Kratos.Model()
        self.part = part = self.model.CreateModelPart("box", 2)
        part.ProcessInfo[Kratos.DOMAIN_SIZE] = box.dim
        for name in ("DISPLACEMENT", "REACTION", "VOLUME_ACCELERATION", "VELOCITY", "ACCELERATION", "WATER_PRESSURE",
                     "REACTION_WATER_PRESSURE", "DT_WATER_PRESSURE"):
            part.AddNodalSolutionStepVariable(Kratos.KratosGlobals.GetVariable(name))
        self.nodes = [part.CreateNewNode(i + 1, *point, *[0.0] * (3 - box.dim)) for i, point in enumerate(box.nodes)]
        self.interface = self._elements(contact_material(box.dim, method, library, **material))
        self._dofs()
        self.strategy = self._strategy(most_iterations)
        self.step = 0

    def _elements(self, contact):
        box, part = self.box, self.part
        blocks, interface = (part.CreateSubModelPart(name) for name in ("blocks", "contact"))
        blocks.AddNodes([node.Id for node in self.nodes])
        interface.AddNodes([int(n) + 1 for n in np.unique(box.contact)])
        none_yet = part.CreateNewProperties(0)
        for number, cell in enumerate(box.blocks, 1):
            kind = f"SmallDisplacementElement{box.dim}D{len(cell)}N"
            blocks.CreateNewElement(kind, number, [int(n) + 1 for n in cell], none_yet)
        cells = box.contact + 1
        half = cells.shape[1] // 2
        if box.dim == 2 and self.method != "coulomb":
            cells = np.hstack([cells[:, :half], cells[:, :half - 1:-1]])  # around
        kind = interface_element(box.dim, self.method)
        for number, cell in enumerate(cells, len(box.blocks) + 1):
            interface.CreateNewElement(kind, number, [int(n) for n in cell], none_yet)
        law = "LinearElasticPlaneStrain2DLaw" if box.dim == 2 else "LinearElastic3DLaw"
        steel = {"DENSITY": 1.0, "YOUNG_MODULUS": YOUNG, "POISSON_RATIO": POISSON, "THICKNESS": 1.0}
        materials = {"properties": [
            {"model_part_name": "box.blocks", "properties_id": 1,
             "Material": {"constitutive_law": {"name": law}, "Variables": steel}},
            {"model_part_name": "box.contact", "properties_id": 2, "Material": contact},
        ]}
        Kratos.ReadMaterialsUtility(self.model).ReadMaterials(Kratos.Parameters(json.dumps(materials)))
        return list(interface.Elements)

    def _dofs(self):
        box = self.box
        # Two-dimensional elements have a third displacement, which they do not use.
        unused = DISPLACEMENT[box.dim:]
        for node in self.nodes:
            for variable, reaction in zip(DISPLACEMENT, REACTION):
                node.AddDof(variable, reaction)
            for variable in unused:
                node.Fix(variable)
        for number in np.unique(box.contact):
            self.nodes[number].AddDof(WATER, WATER_REACTION)
            self.nodes[number].Fix(WATER)
        self.top = [self.nodes[n] for n in box.top]
        self.moving_down = [self.nodes[n] for n in box.upper] if box.case == "sheared" else self.top
        for number in (*box.bottom, *box.top):
            for variable in DISPLACEMENT[:box.dim]:
                self.nodes[number].Fix(variable)
        if box.case == "sheared":
            for node in self.nodes:
                node.Fix(DISPLACEMENT[box.dim - 1])

    def _strategy(self, most_iterations):
        solver = ConstructSolver(Kratos.Parameters('{"solver_type": "LinearSolversApplication.sparse_lu"}'))
        criterion = Kratos.ResidualCriteria(TOLERANCE, 1e-12)
        criterion.SetEchoLevel(0)
        reactions, reform, move = True, False, False
        strategy = Kratos.ResidualBasedNewtonRaphsonStrategy(
            self.part, Kratos.ResidualBasedIncrementalUpdateStaticScheme(), criterion,
            Kratos.ResidualBasedBlockBuilderAndSolver(solver), most_iterations, reactions, reform, move)
        strategy.SetEchoLevel(0)
        strategy.Initialize()
        strategy.Check()
        return strategy

    def move(self, displacement):
        """One step: the top face to a displacement. The iterations it took; raises NotConverged, having undone it."""
        before = self.displacements()
        self.part.CloneTimeStep(float(self.step + 1))
        self.part.ProcessInfo[Kratos.STEP] = self.step + 1
        for node in self.moving_down:
            node.SetSolutionStepValue(DISPLACEMENT[self.box.dim - 1], -self.box.closing)
        for node in self.top:
            for variable, component in zip(DISPLACEMENT, displacement * self.box.direction):
                node.SetSolutionStepValue(variable, float(component))
        self.strategy.InitializeSolutionStep()
        self.strategy.Predict()
        if not self.strategy.SolveSolutionStep():
            # The laws commit in FinalizeSolutionStep: without it only the displacements have to be put back.
            for node, values in zip(self.nodes, before):
                for variable, value in zip(DISPLACEMENT, values):
                    node.SetSolutionStepValue(variable, float(value))
            raise NotConverged(f"displacement {displacement}")
        iterations = self.part.ProcessInfo[Kratos.NL_ITERATION_NUMBER]
        self.strategy.FinalizeSolutionStep()
        self.step += 1
        return iterations

    def displacements(self):
        """All of them, node after node."""
        return np.array([[node.GetSolutionStepValue(v) for v in DISPLACEMENT] for node in self.nodes])

    def forces(self):
        """Force along the direction of the motion, and normal force."""
        total = np.array([[node.GetSolutionStepValue(r) for r in REACTION[:self.box.dim]] for node in self.top])
        if self.box.case == "sheared":
            normal = sum(node.GetSolutionStepValue(REACTION[self.box.dim - 1]) for node in self.moving_down)
        else:
            normal = total[:, -1].sum()
        return float(total.sum(axis=0)[:-1] @ self.box.direction), float(-normal)

    def state(self, number):
        """One state variable (counted from 1) at all points of the contact."""
        variable = Kratos.KratosGlobals.GetVariable(f"STATE_VARIABLE_{number}")
        return np.array([e.CalculateOnIntegrationPoints(variable, self.part.ProcessInfo) for e in self.interface])

    def dissipated(self):
        """Dissipated energy of the contact. The points are at the nodes, each with its share of the element."""
        if self.method == "coulomb":
            return math.nan
        points = self.state(DISSIPATED)
        return float(points.sum() / points.size * self.box.area)

    def run(self, path, progress=lambda steps: steps):
        """Presses the blocks together, then follows the path (its first entry is the start)."""
        record = Record()
        start = time.perf_counter()
        for displacement in progress(path):
            record.iterations.append(self.move(displacement))
            force, normal = self.forces()
            record.displacement.append(float(displacement))
            record.force.append(force)
            record.normal.append(normal)
            record.dissipated.append(self.dissipated())
        record.seconds = time.perf_counter() - start
        return record
