"""SOEM, by pysoem: brings the SubDevice on the cable into OP and says what it reads."""

import json
import time

import ethercat_cable
import pysoem


def main():
    ethercat_cable.plug()
    # A busy computer's relay is no cable: µs.
    pysoem.settings.timeouts.ret = 200_000
    master = pysoem.Master()
    master.open(ethercat_cable.MAIN)
    found = master.config_init()
    assert found == 1, f"expected one SubDevice, found {found}"
    (device,) = master.slaves
    sdo = lambda index, sub: int.from_bytes(device.sdo_read(index, sub), "little", signed=True)
    objects = {
        "force_unit": sdo(0x2021, 0x2F),
        "torque_unit": sdo(0x2021, 0x30),
        "counts_per_force": sdo(0x2021, 0x37),
        "counts_per_torque": sdo(0x2021, 0x38),
    }
    try:
        device.sdo_read(0x2020, 1)
        missing = None
    except pysoem.SdoError as error:
        missing = error.abort_code
    master.config_map()
    state = master.state_check(pysoem.SAFEOP_STATE, 2_000_000)
    assert state == pysoem.SAFEOP_STATE, f"state {state}, status {device.al_status}"
    device.output = bytes(8)
    exchange(master)
    master.state = pysoem.OP_STATE
    master.write_state()
    for _ in range(200):
        exchange(master)
        if master.state_check(pysoem.OP_STATE, 1_000) == pysoem.OP_STATE:
            break
        time.sleep(0.001)
    counters = set()
    for _ in range(100):
        counters.add(exchange(master))
    print(
        json.dumps(
            {
                "vendor": device.man,
                "product": device.id,
                "revision": device.rev,
                "name": device.name,
                **objects,
                "missing": missing,
                "state": master.read_state(),
                "inputs": list(device.input),
                "output_bytes": len(device.output),
                "working_counters": sorted(counters),
                "expected": master.expected_wkc,
            }
        ),
        flush=True,
    )
    # What the test does to the SubDevice now.
    input()
    counters = {exchange(master) for _ in range(20)}
    print(json.dumps({"state": master.read_state(), "working_counters": sorted(counters)}), flush=True)
    master.close()


def exchange(master):
    master.send_processdata()
    return master.receive_processdata(100_000)


main()
