//! The emulated flash: a file of the host that QEMU maps into the board's memory.

use crate::board::block_on::block_on;
use crate::board::flash::{ERASED, FileFlash};
use anyhow::{Context, Result, ensure};
use softdock_app::emulated_flash::{
    BOOT_OPTIONS_OFFSET, BootOptions, Crash, FLASH_BYTES, SETTINGS_OFFSET, SLOT_BYTES,
};
use softdock_app::image::{IMAGE_MAX_BYTES, Image};
use softdock_app::settings::{BoardSettings, Text};
use softdock_app::store::{Origin, Store};
use std::fs::File;
use std::hash::{BuildHasher, Hasher, RandomState};
use std::io::{Read, Seek, SeekFrom, Write};
use std::net::{Ipv4Addr, SocketAddrV4};
use std::path::Path;

/// The board in QEMU's network.
pub(super) const BOARD: Ipv4Addr = Ipv4Addr::new(10, 0, 2, 15);
/// This computer in QEMU's network: the source of traffic from its loopback device.
const HOST: Ipv4Addr = Ipv4Addr::new(10, 0, 2, 2);
/// Length of the network's prefix, bits.
const PREFIX_BITS: u8 = 24;

/// Blocks of bytes with their offsets.
pub(super) type Content = Vec<(usize, Vec<u8>)>;

/// The blocks that the firmware reads at boot.
///
/// # Errors
/// The settings may not be used.
pub(super) fn content(
    settings: &BoardSettings,
    start: bool,
    crash: Option<Crash>,
) -> Result<Content> {
    settings.validate()?;
    let image = Image {
        sequence: 1,
        settings: behind_qemu(settings)?,
    };
    let mut block = vec![0; IMAGE_MAX_BYTES];
    let length = image.encode(&mut block)?;
    block.truncate(length);
    let boot = RandomState::new().build_hasher().finish() as u32;
    let options = BootOptions { start, crash, boot }.encode().to_vec();
    Ok(vec![
        (SETTINGS_OFFSET, block),
        (BOOT_OPTIONS_OFFSET, options),
    ])
}

/// Settings changed for QEMU's network, in which the board's address is given and this computer has another address.
fn behind_qemu(settings: &BoardSettings) -> Result<BoardSettings> {
    let text = |address: &dyn ToString| {
        // 21 characters at most, "255.255.255.255:65535".
        Text::try_from(address.to_string().as_str()).unwrap_or_default()
    };
    let mut behind = settings.clone();
    behind.network.address = text(&BOARD);
    behind.network.prefix_bits = PREFIX_BITS;
    behind.network.gateway = text(&HOST);
    if settings.rsi.robot_ip()?.is_some_and(|ip| ip.is_loopback()) {
        behind.rsi.robot_ip = text(&HOST);
    }
    if let Some(recorder) = settings.network.recorder()?
        && recorder.ip().is_loopback()
    {
        behind.network.recorder = text(&SocketAddrV4::new(HOST, recorder.port()));
    }
    Ok(behind)
}

/// Writes a file of the flash's size: erased up to the last block, with the blocks in it. Nothing is written behind the last
/// block (zeros).
///
/// # Errors
/// The file cannot be written.
pub(super) fn write(path: &Path, content: &Content) -> Result<()> {
    let write = || -> std::io::Result<()> {
        let mut file = File::create(path)?;
        let end = content.iter().map(|(offset, block)| offset + block.len());
        file.write_all(&vec![ERASED; end.max().unwrap_or(0)])?;
        for (offset, block) in content {
            file.seek(SeekFrom::Start(*offset as u64))?;
            file.write_all(block)?;
        }
        file.set_len(FLASH_BYTES as u64)
    };
    write().with_context(|| format!("cannot write the emulated flash to {}", path.display()))
}

/// Prepares a flash that lasts from launch to launch. The contents of its slots stay and only the boot options are new; empty
/// slots get the settings of `content`. Returns the settings with which the board will start, and the file, locked against other
/// boards.
///
/// # Errors
/// The file is no such flash, or cannot be used.
pub(super) fn keep(path: &Path, content: &Content) -> Result<(Option<BoardSettings>, File)> {
    let what = || format!("the emulated flash {}", path.display());
    let open = || File::options().read(true).write(true).open(path);
    if !path.exists() {
        write(path, content)?;
    }
    let mut file = open().with_context(what)?;
    ensure!(
        file.try_lock().is_ok(),
        "{} is in use by another board",
        path.display()
    );
    let length = file.metadata().with_context(what)?.len();
    ensure!(
        length == FLASH_BYTES as u64,
        "{} has {length} bytes; the emulated flash has {FLASH_BYTES}: choose another file",
        path.display()
    );
    let mut put = |offset: usize, block: &[u8]| -> std::io::Result<()> {
        file.seek(SeekFrom::Start(offset as u64))?;
        file.write_all(block)
    };
    for (offset, block) in content
        .iter()
        .filter(|(offset, _)| *offset == BOOT_OPTIONS_OFFSET)
    {
        put(*offset, block).with_context(what)?;
    }
    let mut slots = vec![0; 2 * SLOT_BYTES];
    file.seek(SeekFrom::Start(SETTINGS_OFFSET as u64))
        .and_then(|_| file.read_exact(&mut slots))
        .with_context(what)?;
    let mut store = Store::new(FileFlash::<SLOT_BYTES>::of(slots));
    let boot = block_on(store.boot(None, &mut [0; IMAGE_MAX_BYTES]));
    let settings = match boot.origin {
        Origin::Defaults(_) => None,
        _ => Some(boot.settings),
    };
    Ok((settings, file))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn stored(settings: &BoardSettings) -> BoardSettings {
        let content = content(settings, true, None).unwrap();
        Image::decode(&content[0].1).unwrap().settings
    }

    #[test]
    fn this_computer_has_another_address_in_the_network_of_qemu() {
        let mut settings = BoardSettings::default();
        settings.rsi.robot_ip = Text::try_from("127.0.0.1").unwrap();
        settings.network.recorder = Text::try_from("127.0.0.1:49200").unwrap();
        let stored = stored(&settings);
        assert_eq!(stored.rsi.robot_ip, "10.0.2.2");
        assert_eq!(stored.network.recorder, "10.0.2.2:49200");
        assert_eq!(stored.network.address, "10.0.2.15");
        assert_eq!(stored.control, settings.control);
    }

    #[test]
    fn addresses_of_other_computers_stay() {
        let mut settings = BoardSettings::default();
        settings.rsi.robot_ip = Text::try_from("192.168.1.10").unwrap();
        settings.network.recorder = Text::try_from("192.168.1.5:49200").unwrap();
        let stored = stored(&settings);
        assert_eq!(stored.rsi, settings.rsi);
        assert_eq!(stored.network.recorder, settings.network.recorder);
        let anyone = BoardSettings::default();
        assert_eq!(super::tests::stored(&anyone).rsi, anyone.rsi);
    }

    #[test]
    fn a_flash_that_lasts_keeps_its_settings() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("flash.bin");
        let mut settings = BoardSettings::default();
        settings.can.base_id = 9;
        let first = keep(&path, &content(&settings, false, None).unwrap()).unwrap();
        assert_eq!(first.0.unwrap().can.base_id, 9);
        let other = content(&BoardSettings::default(), true, None).unwrap();
        let taken = keep(&path, &other).unwrap_err().to_string();
        assert!(taken.contains("in use by another board"), "{taken}");
        drop(first.1);
        let (kept, _) = keep(&path, &other).unwrap();
        assert_eq!(kept.unwrap().can.base_id, 9);
        let bytes = std::fs::read(&path).unwrap();
        assert!(BootOptions::decode(&bytes[BOOT_OPTIONS_OFFSET..]).start);
        std::fs::write(&path, "something else").unwrap();
        assert!(keep(&path, &other).is_err());
    }

    #[test]
    fn the_file_is_the_whole_flash_with_each_block_in_its_place() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("flash.bin");
        let settings = BoardSettings::default();
        write(&path, &content(&settings, true, None).unwrap()).unwrap();
        let bytes = std::fs::read(&path).unwrap();
        assert_eq!(bytes.len(), FLASH_BYTES);
        assert_eq!(Image::decode(&bytes).unwrap().sequence, 1);
        assert!(BootOptions::decode(&bytes[BOOT_OPTIONS_OFFSET..]).start);
        assert_eq!(bytes[BOOT_OPTIONS_OFFSET - 1], ERASED);
    }
}
