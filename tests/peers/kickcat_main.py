"""KickCAT: brings the SubDevice on the cable into OP and says what it reads."""

import json
import time

import ethercat_cable
import kickcat


def main():
    ethercat_cable.plug()
    link = kickcat.create_link(ethercat_cable.MAIN, "")
    # A busy computer's relay is no cable: s.
    link.set_timeout(0.5)
    bus = kickcat.Bus(link)
    bus.init(1.0)
    (device,) = bus.slaves()

    def sdo(index, sub, size):
        value = bus.read_sdo(device, index, sub, kickcat.Access.PARTIAL, size, 1.0)
        return int.from_bytes(value, "little", signed=size == 4 and index != 0x1018)

    read = {
        "vendor": sdo(0x1018, 1, 4),
        "product": sdo(0x1018, 2, 4),
        "revision": sdo(0x1018, 3, 4),
        "force_unit": sdo(0x2021, 0x2F, 1),
        "torque_unit": sdo(0x2021, 0x30, 1),
        "counts_per_force": sdo(0x2021, 0x37, 4),
        "counts_per_torque": sdo(0x2021, 0x38, 4),
    }
    bus.create_mapping(4096)
    bus.request_state(kickcat.State.SAFE_OP)
    bus.wait_for_state(kickcat.State.SAFE_OP, 2.0)
    device.set_output_bytes(bytes(device.output_size))
    bus.process_data_no_check()
    bus.request_state(kickcat.State.OPERATIONAL)
    bus.wait_for_state(kickcat.State.OPERATIONAL, 2.0, bus.process_data_no_check)
    for _ in range(100):
        # Raises if a working counter is not what it should be.
        bus.process_data()
        time.sleep(0.001)
    read["inputs"] = list(bytes(device.input_data))
    read["output_bytes"] = device.output_size
    read["state"] = int(bus.get_state(device).value)
    print(json.dumps(read), flush=True)
    # What the test does to the SubDevice now.
    input()
    for _ in range(20):
        bus.process_data_no_check()
    try:
        seen = f"state {bus.get_state(device)}"
    except kickcat.ErrorAL as error:
        seen = str(error)
    print(json.dumps({"seen": seen}), flush=True)


main()
