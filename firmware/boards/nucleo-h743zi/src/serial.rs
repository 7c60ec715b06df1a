//! The serial port of the parameter service: USART3, which the ST-Link forwards to USB (CN1).

use embassy_stm32::peripherals::{PD8, PD9, USART3};
use embassy_stm32::usart::{
    BufferedInterruptHandler, BufferedUart, BufferedUartRx, BufferedUartTx, Config, ConfigError,
};
use embassy_stm32::{Peri, bind_interrupts};
use static_cell::ConstStaticCell;

/// Bits per second.
const BAUD_RATE: u32 = 115_200;
/// Received bytes that may wait for the service: 40 ms, while it is interrupted or writes flash. The other side repeats lost
/// bytes.
const RECEIVE_BYTES: usize = 512;
/// Bytes that may wait to be sent.
const SEND_BYTES: usize = 256;

bind_interrupts!(struct Irqs {
    USART3 => BufferedInterruptHandler<USART3>;
});

/// Port and pins, as they are wired to the ST-Link (UM2407, USART communication).
pub(crate) struct Pins {
    pub(crate) usart: Peri<'static, USART3>,
    pub(crate) rx: Peri<'static, PD9>,
    pub(crate) tx: Peri<'static, PD8>,
}

/// Opens the port. To be called once.
pub(crate) fn open(
    pins: Pins,
) -> Result<(BufferedUartRx<'static>, BufferedUartTx<'static>), ConfigError> {
    static RECEIVED: ConstStaticCell<[u8; RECEIVE_BYTES]> =
        ConstStaticCell::new([0; RECEIVE_BYTES]);
    static TO_SEND: ConstStaticCell<[u8; SEND_BYTES]> = ConstStaticCell::new([0; SEND_BYTES]);
    let mut config = Config::default();
    config.baudrate = BAUD_RATE;
    let (to_send, received) = (TO_SEND.take(), RECEIVED.take());
    let uart = BufferedUart::new(
        pins.usart, pins.rx, pins.tx, to_send, received, Irqs, config,
    )?;
    let (tx, rx) = uart.split();
    Ok((rx, tx))
}
