//! MainDevices that this project did not make, SOEM and KickCAT, bring the simulated SubDevice into OP, and read what
//! ethercrab reads.

use serde_json::Value;
use softdock_link::ethercat::{ATI_VENDOR, INPUT_BYTES, Inputs, OUTPUT_BYTES, Product};
use softdock_rig::ethercat::wire::plug;
use softdock_rig::ethercat::{Description, Measurement, Segment, SubDevice};
use softdock_tests::peers::python::on_cable;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;

const COUNTS: [i32; 6] = [1_000_000, -2_000_000, 3, -4, i32::MAX, i32::MIN];
/// AL states.
const OPERATIONAL: i64 = 8;
const SAFE_OP: i64 = 4;

/// Lets a program in Python read the sensor, and again after the SubDevice has left OP.
fn read_by(script: &str) -> Option<[Value; 2]> {
    let (mut process, cable) = on_cable(script)?;
    let [unplugged, fall] = [const { AtomicBool::new(false) }; 2];
    let said = thread::scope(|scope| {
        scope.spawn(|| {
            let axia = SubDevice::new(Description::of(Product::Axia80));
            let mut segment = Segment::new(vec![axia]);
            plug(cable, &unplugged, &mut segment, |segment, _| {
                let device = &mut segment.devices[0];
                device.measure(Measurement {
                    counts: COUNTS,
                    status: 0,
                });
                if fall.swap(false, Ordering::Relaxed) {
                    device.fall_to_safe_op();
                }
            })
        });
        let said = [(); 2].map(|()| {
            let line = process.heard_or_ended("{");
            if line.is_some() {
                fall.store(true, Ordering::Relaxed);
                process.say("go on");
            }
            line
        });
        unplugged.store(true, Ordering::Relaxed);
        said
    });
    let (status, log) = process.finish();
    let said = said.map(|line| line.unwrap_or_else(|| panic!("{script} ended\n{log}")));
    assert!(status.success(), "{log}");
    Some(said.map(|line| serde_json::from_str(&line).unwrap()))
}

fn assert_reads_the_sensor(read: &Value) {
    let number = |name: &str| {
        read[name]
            .as_i64()
            .unwrap_or_else(|| panic!("{name}: {read}"))
    };
    let about = Description::of(Product::Axia80);
    assert_eq!(number("vendor"), i64::from(ATI_VENDOR));
    assert_eq!(number("product"), i64::from(about.product));
    assert_eq!(number("revision"), i64::from(about.revision));
    assert_eq!(number("force_unit"), i64::from(about.units.0));
    assert_eq!(number("torque_unit"), i64::from(about.units.1));
    assert_eq!(
        number("counts_per_force"),
        i64::from(about.counts_per_unit.0)
    );
    assert_eq!(
        number("counts_per_torque"),
        i64::from(about.counts_per_unit.1)
    );
    assert_eq!(number("output_bytes"), OUTPUT_BYTES as i64);
    assert_eq!(number("state"), OPERATIONAL);
    let bytes: Vec<u8> = serde_json::from_value(read["inputs"].clone()).unwrap();
    let bytes: [u8; INPUT_BYTES] = bytes.try_into().unwrap();
    let inputs = Inputs::decode(&bytes);
    assert_eq!((inputs.counts, inputs.status), (COUNTS, 0));
    assert!(inputs.sample > 100, "{inputs:?}");
}

#[test]
#[ignore = "long: EtherCAT MainDevices from the Python package index"]
fn soem_reads_the_sensor_and_sees_it_fall() {
    let Some([read, fallen]) = read_by("soem.py") else {
        return;
    };
    assert_reads_the_sensor(&read);
    assert_eq!(read["name"], Description::of(Product::Axia80).name);
    // Object does not exist (ETG.1000.6, table 41).
    assert_eq!(read["missing"], 0x0602_0000);
    assert_eq!(read["working_counters"], serde_json::json!([3]));
    assert_eq!(read["expected"], 3);
    assert_eq!(fallen["state"], SAFE_OP);
}

#[test]
#[ignore = "long: EtherCAT MainDevices from the Python package index"]
fn kickcat_reads_the_sensor_and_sees_it_fall() {
    let Some([read, fallen]) = read_by("kickcat_main.py") else {
        return;
    };
    assert_reads_the_sensor(&read);
    let seen = fallen["seen"].as_str().unwrap();
    assert!(seen.contains("State transition error"), "{seen}");
}
