"""Basilisk's loop, for a Python that has Basilisk: a rigid spacecraft at 100 Hz, MRP feedback at 10 Hz, no recorders.

    python basilisk_loop.py SECONDS      prints JSON: simulated seconds per CPU second, rate and attitude error left

Imports nothing of this repository: its interpreter need not have it.
"""

import json
import math
import sys
import time

from Basilisk.architecture import messaging
from Basilisk.fswAlgorithms import attTrackingError, mrpFeedback
from Basilisk.simulation import extForceTorque, simpleNav, spacecraft
from Basilisk.utilities import SimulationBaseClass, macros

PLANT_STEP, CONTROL_STEP = 0.01, 0.1
INERTIA = [10.0, 1.2, 0.5, 1.2, 19.0, 1.5, 0.5, 1.5, 25.0]


def main() -> None:
    seconds = float(sys.argv[1])
    sim = SimulationBaseClass.SimBaseClass()
    process = sim.CreateNewProcess("process")
    process.addTask(sim.CreateNewTask("plant", macros.sec2nano(PLANT_STEP)))
    process.addTask(sim.CreateNewTask("control", macros.sec2nano(CONTROL_STEP)))

    body = spacecraft.Spacecraft()
    body.hub.mHub = 100.0
    body.hub.IHubPntBc_B = [INERTIA[0:3], INERTIA[3:6], INERTIA[6:9]]
    body.hub.sigma_BNInit = [[-0.05], [0.05], [-0.05]]
    body.hub.omega_BN_BInit = [[0.005], [0.006], [0.004]]
    torque = extForceTorque.ExtForceTorque()
    body.addDynamicEffector(torque)
    navigation = simpleNav.SimpleNav()
    error = attTrackingError.attTrackingError()
    law = mrpFeedback.mrpFeedback()
    law.K, law.P, law.Ki = 3.0, 5.0, -1.0  # without the integral
    reference = messaging.AttRefMsg().write(messaging.AttRefMsgPayload())
    vehicle = messaging.VehicleConfigMsg().write(messaging.VehicleConfigMsgPayload(ISCPntB_B=INERTIA))
    navigation.scStateInMsg.subscribeTo(body.scStateOutMsg)
    error.attNavInMsg.subscribeTo(navigation.attOutMsg)
    error.attRefInMsg.subscribeTo(reference)
    law.guidInMsg.subscribeTo(error.attGuidOutMsg)
    law.vehConfigInMsg.subscribeTo(vehicle)
    torque.cmdTorqueInMsg.subscribeTo(law.cmdTorqueOutMsg)
    for task, modules in (("plant", (torque, body)), ("control", (navigation, error, law))):
        for module in modules:
            sim.AddModelToTask(task, module)

    sim.InitializeSimulation()
    sim.ConfigureStopTime(macros.sec2nano(seconds))
    began = time.process_time()
    sim.ExecuteSimulation()
    cpu = time.process_time() - began
    left = error.attGuidOutMsg.read()
    print(
        json.dumps(
            {
                "simulated_s_per_cpu_s": seconds / cpu,
                "attitude_error": math.hypot(*left.sigma_BR),
                "rate_error": math.hypot(*left.omega_BR_B),
            }
        )
    )


if __name__ == "__main__":
    main()
