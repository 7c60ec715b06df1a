//! Start-up of the SubDevice, and exchanges of process data.

use super::bus::Wire;
use crate::board::Clock;
use core::time::Duration;
use embassy_futures::select::{Either, select};
use ethercrab::error::{Error, TimeoutError};
use ethercrab::subdevice_group::{Op, PreOp};
use ethercrab::{
    Command, MainDevice, MainDeviceConfig, RegisterAddress, RetryBehaviour, SubDeviceGroup,
    SubDeviceRef, Timeouts,
};
use softdock_link::ethercat::{Exchange, INPUT_BYTES, OUTPUT_BYTES, Product, Setup, StartUp};
use softdock_link::sensor::SensorFault;

/// For the start-up, which takes about 200 frames: a single frame may be lost, or late on a busy computer, without failing it.
/// Exchanges have their own timeout.
pub(super) const TIMEOUTS: Timeouts = Timeouts {
    state_transition: Duration::from_secs(1),
    pdu: Duration::from_millis(10),
    eeprom: Duration::from_millis(100),
    wait_loop_delay: Duration::from_micros(200),
    mailbox_echo: Duration::from_millis(200),
    mailbox_response: Duration::from_millis(500),
};

/// No distributed clocks: their synchronisation would take 10,000 frames.
pub(super) const CONFIG: MainDeviceConfig = MainDeviceConfig {
    dc_static_sync_iterations: 0,
    retry_behaviour: RetryBehaviour::Count(2),
};

/// Longest start-up, µs.
const START_UP_US: u64 = 3_000_000;
/// Pause between two exchanges while the SubDevice comes into OP, µs.
const OP_TICK_US: u64 = 1_000;

/// Room for SubDevices; ethercrab asks for a power of two beyond one.
const SUBDEVICES: usize = 2;
/// Room for process data: more than the sensor's, so that a wrong size is noticed.
const PROCESS_DATA_BYTES: usize = 128;

type Group<State> = SubDeviceGroup<SUBDEVICES, PROCESS_DATA_BYTES, ethercrab::DefaultLock, State>;

/// Carries out requests for ever.
pub(super) async fn serve(
    wire: &Wire,
    main_device: &MainDevice<'_>,
    clock: &impl Clock,
    timeout_us: u64,
) {
    let mut group = None;
    loop {
        let request = wire.request.wait().await;
        let now_us = clock.now_us();
        let answer = match request {
            Exchange::StartUp => {
                group = None;
                let end = clock.wait_until(now_us + START_UP_US);
                let answer = match select(start_up(main_device, clock), end).await {
                    Either::First(Ok((operational, setup))) => {
                        group = Some(operational);
                        Exchange::Ready(setup)
                    }
                    Either::First(Err(fault)) => Exchange::Failed(fault),
                    Either::Second(()) => Exchange::Failed(SensorFault::StartUp(StartUp::Op)),
                };
                Some(answer)
            }
            Exchange::Outputs(outputs) => match &group {
                None => None,
                Some(group) => {
                    let end = clock.wait_until(now_us + timeout_us);
                    match select(exchange(main_device, group, &outputs), end).await {
                        Either::First(answer) => answer,
                        // The driver knows when to give up.
                        Either::Second(()) => None,
                    }
                }
            },
            Exchange::Ready(_) | Exchange::Failed(_) | Exchange::Inputs { .. } => None,
        };
        if let Some(answer) = answer {
            wire.answer.signal(answer);
        }
    }
}

/// One LRW and the state of the SubDevice, in one frame.
async fn exchange(
    main_device: &MainDevice<'_>,
    group: &Group<Op>,
    outputs: &[u8; OUTPUT_BYTES],
) -> Option<Exchange> {
    let subdevice = group.subdevice(main_device, 0).ok()?;
    let mut data = subdevice.io_raw_mut();
    data.outputs()
        .first_chunk_mut()
        .map(|place| *place = *outputs)?;
    drop(data);
    let response = group.tx_rx(main_device).await.ok()?;
    let bytes = *subdevice.io_raw().inputs().first_chunk::<INPUT_BYTES>()?;
    Some(Exchange::Inputs {
        working_counter: response.working_counter,
        operational: response.all_op(),
        bytes,
    })
}

/// From whatever the SubDevice is in to OP, with all checks on the way.
async fn start_up(
    main_device: &MainDevice<'_>,
    clock: &impl Clock,
) -> Result<(Group<Op>, Setup), SensorFault> {
    alone(main_device).await?;
    let group = main_device
        .init_single_group::<SUBDEVICES, PROCESS_DATA_BYTES>(|| clock.now_us() * 1000)
        .await
        .map_err(|error| fault(error, StartUp::PreOp))?;
    let setup = setup(main_device, &group).await?;
    let group = group
        .into_pre_op_pdi(main_device)
        .await
        .map_err(|error| match error {
            Error::PdiTooLong { desired_length, .. } => SensorFault::PdoBytes {
                inputs: u16::try_from(desired_length).unwrap_or(u16::MAX),
                outputs: 0,
            },
            error => fault(error, StartUp::SafeOp),
        })?;
    let [inputs, outputs] = {
        let subdevice = group.subdevice(main_device, 0);
        let subdevice = subdevice.map_err(|error| fault(error, StartUp::SafeOp))?;
        let data = subdevice.io_raw();
        [data.inputs().len(), data.outputs().len()]
    };
    if (inputs, outputs) != (INPUT_BYTES, OUTPUT_BYTES) {
        // Both are shorter than `PROCESS_DATA_BYTES`.
        let (inputs, outputs) = (inputs as u16, outputs as u16);
        return Err(SensorFault::PdoBytes { inputs, outputs });
    }
    let group = group.into_safe_op(main_device).await;
    let group = group.map_err(|error| fault(error, StartUp::SafeOp))?;
    let group = group.request_into_op(main_device).await;
    let group = group.map_err(|error| fault(error, StartUp::Op))?;
    // Many SubDevices need outputs before they enter OP. The caller's timeout bounds this loop.
    loop {
        let response = group.tx_rx(main_device).await;
        let response = response.map_err(|error| fault(error, StartUp::Op))?;
        if response.all_op() {
            return Ok((group, setup));
        }
        clock.wait_until(clock.now_us() + OP_TICK_US).await;
    }
}

/// Checks that there is exactly one SubDevice, as ethercrab's discovery is not made for other segments.
async fn alone(main_device: &MainDevice<'_>) -> Result<(), SensorFault> {
    let counted = Command::brd(RegisterAddress::Type.into())
        .with_wkc(1)
        .receive::<u8>(main_device)
        .await;
    match counted {
        Ok(_) => Ok(()),
        Err(Error::WorkingCounter { received: 0, .. }) => Err(SensorFault::NoSubDevice),
        Err(Error::WorkingCounter { received, .. }) => Err(SensorFault::SubDevices { received }),
        Err(error) => Err(fault(error, StartUp::PreOp)),
    }
}

/// Identity and calibration.
async fn setup(main_device: &MainDevice<'_>, group: &Group<PreOp>) -> Result<Setup, SensorFault> {
    let subdevice = group.subdevice(main_device, 0);
    let subdevice = subdevice.map_err(|error| fault(error, StartUp::PreOp))?;
    let identity = subdevice.identity();
    let (vendor, product) = (identity.vendor_id, identity.product_id);
    let object = Product::identify(vendor, product)?.calibration();
    let unreadable = |_| SensorFault::Object {
        index: object.index,
    };
    let subdevice: &SubDeviceRef<'_, _> = &subdevice;
    let (index, [force, torque]) = (object.index, [object.force_unit, object.torque_unit]);
    let [per_force, per_torque] = [object.counts_per_force, object.counts_per_torque];
    Ok(Setup {
        vendor,
        product,
        force_unit: subdevice.sdo_read(index, force).await.map_err(unreadable)?,
        torque_unit: subdevice
            .sdo_read(index, torque)
            .await
            .map_err(unreadable)?,
        counts_per_force: subdevice
            .sdo_read(index, per_force)
            .await
            .map_err(unreadable)?,
        counts_per_torque: subdevice
            .sdo_read(index, per_torque)
            .await
            .map_err(unreadable)?,
    })
}

/// A silent segment, or a step that the SubDevice did not take.
fn fault(error: Error, step: StartUp) -> SensorFault {
    match error {
        Error::Timeout(TimeoutError::Pdu) => SensorFault::NoAnswer,
        _ => SensorFault::StartUp(step),
    }
}
