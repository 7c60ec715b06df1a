use super::*;
use tempfile::TempDir;

/// A store in a folder of its own.
fn store() -> (TempDir, Store) {
    let folder = tempfile::tempdir().unwrap();
    let store = Store::open(&format!("file://{}/a campaign", folder.path().display()));
    (folder, store.unwrap())
}

#[test]
fn what_was_put_is_listed_and_comes_back() {
    let (folder, store) = store();
    assert!(store.names().unwrap().is_empty());
    assert_eq!(store.read("plan.json").unwrap(), None);
    store.add("plan.json", b"plan".to_vec()).unwrap();
    store.add("part", b"part".to_vec()).unwrap();
    assert_eq!(store.names().unwrap(), ["part", "plan.json"]);
    assert_eq!(store.read("plan.json").unwrap().unwrap(), b"plan");
    let file = folder.path().join("a campaign/plan.json");
    assert_eq!(std::fs::read(file).unwrap(), b"plan");
    assert_eq!(store.on_disk(), Some(&*folder.path().join("a campaign")));
}

#[test]
fn what_is_there_is_never_replaced() {
    let (_folder, store) = store();
    store.add("part", b"one".to_vec()).unwrap();
    // The answer to the first attempt was lost.
    store.add("part", b"one".to_vec()).unwrap();
    let error = store.add("part", b"two".to_vec()).unwrap_err().to_string();
    assert!(error.contains("another part is in"), "{error}");
    assert_eq!(store.read("part").unwrap().unwrap(), b"one");
}

#[test]
fn what_was_put_half_is_not_there() {
    let (folder, store) = store();
    store.add("plan.json", b"plan".to_vec()).unwrap();
    // A put to a file system that was interrupted.
    let half = folder.path().join("a campaign/part-0-of-1.parquet#1");
    std::fs::write(half, b"pa").unwrap();
    assert_eq!(store.names().unwrap(), ["plan.json"]);
    store.add("part-0-of-1.parquet", b"part".to_vec()).unwrap();
    let part = store.read("part-0-of-1.parquet").unwrap();
    assert_eq!(part.unwrap(), b"part");
}

#[test]
fn journals_belong_to_an_address_however_it_is_written() {
    let at = |address: &str| Store::open(address).unwrap().journals();
    assert_eq!(at("file:///shared/a"), at("file:///shared/a/"));
    assert_ne!(at("file:///shared/a"), at("file:///shared/b"));
}

#[test]
fn an_address_that_is_none_says_what_one_is() {
    for address in [
        "memory:///c",
        "https://example.com/c",
        "ftp://host/c",
        "s3://",
    ] {
        let error = format!("{:#}", Store::open(address).unwrap_err());
        let said = error.contains("expected") && error.contains("s3://..");
        assert!(said || error.contains("no address"), "{address}: {error}");
    }
}

#[test]
#[cfg(not(any(feature = "s3", feature = "gcs", feature = "azure")))]
fn a_store_that_is_not_built_in_says_how_it_gets_in() {
    for (address, feature) in [
        ("s3://b/c", "s3"),
        ("gs://b/c", "gcs"),
        ("az://b/c", "azure"),
    ] {
        let error = Store::open(address).unwrap_err().to_string();
        assert!(error.contains(&format!("--features {feature}`")), "{error}");
    }
}
