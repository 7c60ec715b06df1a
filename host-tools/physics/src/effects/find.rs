//! Finds an effect by id, or by a word that the user remembers.

use super::{CATALOGUE, Effect, by_id};
use anyhow::{Result, bail};
use softdock_io::input::nearest;

/// Most effects that are offered for a word.
const OFFERED: usize = 5;

/// The effect with this id.
///
/// # Errors
/// There is no such effect; the error suggests the nearest id, or effects with the word in id, title or summary.
pub fn named(id: &str) -> Result<&'static Effect> {
    match by_id(id) {
        Some(effect) => Ok(effect),
        None => bail!("there is no effect `{id}`; {}", hint(id, [])),
    }
}

/// A suggestion for an unknown id: the nearest id, also among the user's `own`, or effects with the word in id, title or summary.
pub fn hint<'a>(id: &str, own: impl IntoIterator<Item = &'a str>) -> String {
    const LIST: &str = "`softdock effects` lists them all";
    let known = CATALOGUE.iter().map(|effect| effect.id).chain(own);
    if let Some(near) = nearest(id, known) {
        return format!("did you mean `{near}`? ({LIST})");
    }
    let word = id.to_lowercase().replace('_', " ");
    let has = |effect: &&&Effect| {
        [&effect.id.replace('_', " "), effect.title, effect.summary]
            .iter()
            .any(|text| !word.is_empty() && text.to_lowercase().contains(&word))
    };
    let offered = CATALOGUE.iter().filter(has).take(OFFERED);
    let offered: Vec<String> = offered
        .map(|e| format!("`{}` ({})", e.id, e.title))
        .collect();
    match offered.is_empty() {
        true => LIST.to_owned(),
        false => format!("the word is in {} ({LIST})", offered.join(", ")),
    }
}

#[cfg(test)]
mod tests {
    use super::named;

    #[test]
    fn a_word_of_the_title_is_enough_to_be_told_the_id() {
        assert_eq!(named("ft_bias").unwrap().id, "ft_bias");
        for (word, offered) in [
            ("guide_colomb", "did you mean `guide_coulomb`?"),
            ("friction", "`guide_coulomb`"),
            ("coulomb", "`guide_coulomb`"),
            ("Zero offset", "`ft_bias` (Zero offset of the sensor)"),
            ("xyzzy", "`softdock effects` lists them all"),
            ("", "`softdock effects` lists them all"),
        ] {
            let error = named(word).unwrap_err().to_string();
            assert!(error.contains(offered), "{error}");
        }
    }
}
