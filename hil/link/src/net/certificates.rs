//! The keys of a lab: one authority, a certificate per member whose common name is the member's, and the access list.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use rcgen::{
    BasicConstraints, CertificateParams, DnType, ExtendedKeyUsagePurpose, IsCa, Issuer, KeyPair,
    KeyUsagePurpose,
};
use serde_json::{Value, json};
use thiserror::Error;
use time::{Duration, OffsetDateTime};
use x509_parser::pem::parse_x509_pem;

use super::access::{Access, Member};

const AUTHORITY: &str = "ca.pem";
const AUTHORITY_KEY: &str = "ca.key";
const CERTIFICATE: &str = "cert.pem";
const KEY: &str = "key.pem";
const ACCESS: &str = "access.toml";

/// Days for which the authority lasts: ten years.
const AUTHORITY_DAYS: i64 = 3650;

/// Time before its making from which a certificate counts, since clocks of two machines may differ.
const BEFORE: Duration = Duration::hours(1);

/// Errors of keys and certificates.
#[derive(Debug, Error)]
pub enum LabError {
    /// A file that cannot be read or written.
    #[error("{path}: {source}")]
    File {
        /// The file.
        path: PathBuf,
        /// Error of the system.
        source: io::Error,
    },
    /// A file with other content than its name promises.
    #[error("{path}: expected {expected}; make it with `palpate-link keys`")]
    Content {
        /// The file.
        path: PathBuf,
        /// Content that the file should have.
        expected: String,
    },
    /// A certificate whose time is over, or has not come.
    #[error(
        "{path}: the certificate of `{name}` counts from {from} to {until}; make another with `palpate-link keys`"
    )]
    Time {
        /// The certificate's file.
        path: PathBuf,
        /// Name in the certificate.
        name: String,
        /// Time from which it counts.
        from: String,
        /// Time until which it counts.
        until: String,
    },
    /// A certificate of another lab's authority.
    #[error(
        "{path}: the certificate of `{name}` is not of the authority in {AUTHORITY} beside it; copy the whole folder that `palpate-link keys` made"
    )]
    Foreign {
        /// The certificate's file.
        path: PathBuf,
        /// Name in the certificate.
        name: String,
    },
    /// Error of the access list.
    #[error("{0}")]
    Access(String),
    /// Error of the cryptography.
    #[error("certificates: {0}")]
    Made(#[from] rcgen::Error),
}

/// The keys of one member, read.
#[derive(Debug)]
pub struct Lab {
    folder: PathBuf,
    /// The name in its certificate.
    pub name: String,
    /// Rights of all members.
    pub access: Access,
    until: OffsetDateTime,
}

fn file(path: &Path) -> impl FnOnce(io::Error) -> LabError {
    let path = path.to_owned();
    move |source| LabError::File { path, source }
}

fn read(path: &Path) -> Result<String, LabError> {
    fs::read_to_string(path).map_err(file(path))
}

/// Writes a file that only its owner may read, never into one that is there: that may have another mode, and be open elsewhere.
fn write_secret(path: &Path, text: &str) -> Result<(), LabError> {
    use std::io::Write as _;
    use std::os::unix::fs::OpenOptionsExt as _;
    match fs::remove_file(path) {
        Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(file(path)(error)),
        _ => {}
    }
    let mut options = fs::OpenOptions::new();
    options.write(true).create_new(true).mode(0o600);
    let mut out = options.open(path).map_err(file(path))?;
    out.write_all(text.as_bytes()).map_err(file(path))
}

fn write(path: &Path, text: &str) -> Result<(), LabError> {
    fs::write(path, text).map_err(file(path))
}

fn now() -> OffsetDateTime {
    OffsetDateTime::now_utc()
}

impl Lab {
    /// Makes keys for these members in a folder of each one's name below `folder`, which holds the lab's authority: it is
    /// made where there is none. Members that the list has already keep their keys, unless they are named again. Every
    /// folder of a member gets the whole list. Certificates that are made count for so long from now on.
    ///
    /// # Errors
    /// [`LabError`] for files that cannot be read or written.
    pub fn make(folder: &Path, wanted: &[Member], lasts: Duration) -> Result<Access, LabError> {
        fs::create_dir_all(folder).map_err(file(folder))?;
        let (authority, issuer) = authority(folder)?;
        let path = folder.join(ACCESS);
        let mut access = match fs::read_to_string(&path) {
            Ok(text) => Access::read(&path, &text).map_err(LabError::Access)?,
            Err(_) => Access::default(),
        };
        for one in wanted {
            access.members.retain(|m| m.name != one.name);
            access.members.push(one.clone());
            let own = folder.join(&one.name);
            fs::create_dir_all(&own).map_err(file(&own))?;
            let key = KeyPair::generate()?;
            // Tools other than this one look for a name of the machine.
            let mut params = CertificateParams::new([one.name.clone()])?;
            let name = one.name.as_str();
            params.distinguished_name.push(DnType::CommonName, name);
            params.not_before = now() - BEFORE;
            params.not_after = now() + lasts;
            params.key_usages = vec![KeyUsagePurpose::DigitalSignature];
            params.extended_key_usages = vec![
                ExtendedKeyUsagePurpose::ServerAuth,
                ExtendedKeyUsagePurpose::ClientAuth,
            ];
            params.use_authority_key_identifier_extension = true;
            write(
                &own.join(CERTIFICATE),
                &params.signed_by(&key, &issuer)?.pem(),
            )?;
            write_secret(&own.join(KEY), &key.serialize_pem())?;
            write(&own.join(AUTHORITY), &authority)?;
        }
        let text = toml::to_string(&access).map_err(|e| LabError::Access(e.to_string()))?;
        let text = format!(
            "# Who may publish which fingers, and who may feel them. Machines read it when they start.\n\n{text}"
        );
        write(&path, &text)?;
        for member in &access.members {
            write(&folder.join(&member.name).join(ACCESS), &text)?;
        }
        Ok(access)
    }

    /// Reads the keys of a member, and looks whether they can be those of today and of one lab.
    ///
    /// # Errors
    /// [`LabError`] with the file.
    pub fn member(folder: &Path) -> Result<Self, LabError> {
        let path = folder.join(ACCESS);
        let access = Access::read(&path, &read(&path)?).map_err(LabError::Access)?;
        read(&folder.join(KEY))?;
        let path = folder.join(CERTIFICATE);
        let content = |path: &Path, expected: &str| LabError::Content {
            path: path.to_owned(),
            expected: expected.into(),
        };
        let pem = read(&path)?;
        let (_, block) =
            parse_x509_pem(pem.as_bytes()).map_err(|_| content(&path, "a certificate"))?;
        let own = block
            .parse_x509()
            .map_err(|_| content(&path, "a certificate"))?;
        let name = own.subject().iter_common_name().next();
        let name = name
            .and_then(|n| n.as_str().ok())
            .unwrap_or_default()
            .to_owned();
        let validity = own.validity();
        if !validity.is_valid() {
            let (from, until) = (
                validity.not_before.to_string(),
                validity.not_after.to_string(),
            );
            return Err(LabError::Time {
                path,
                name,
                from,
                until,
            });
        }
        let authority_path = folder.join(AUTHORITY);
        let pem = read(&authority_path)?;
        let wrong = || content(&authority_path, "the certificate of an authority");
        let (_, block) = parse_x509_pem(pem.as_bytes()).map_err(|_| wrong())?;
        let authority = block.parse_x509().map_err(|_| wrong())?;
        if own.verify_signature(Some(authority.public_key())).is_err() {
            return Err(LabError::Foreign { path, name });
        }
        Ok(Self {
            folder: folder.to_owned(),
            until: validity.not_after.to_datetime(),
            name,
            access,
        })
    }

    /// Tells whether its certificate counts no more, by the whole seconds of TLS.
    #[must_use]
    pub fn has_expired(&self) -> bool {
        now() >= self.until + Duration::SECOND
    }

    /// Zenoh's settings of TLS: both ends show a certificate, and a link ends when one expires.
    #[must_use]
    pub fn settings(&self) -> Value {
        let path = |name: &str| self.folder.join(name).display().to_string();
        json!({
            "root_ca_certificate": path(AUTHORITY),
            "listen_certificate": path(CERTIFICATE),
            "listen_private_key": path(KEY),
            "connect_certificate": path(CERTIFICATE),
            "connect_private_key": path(KEY),
            "enable_mtls": true,
            // A machine's certificate names it, and the access list knows it by that; addresses change.
            "verify_name_on_connect": false,
            "close_link_on_expiration": true,
        })
    }
}

/// The authority of a lab: its certificate, and its signer.
fn authority(folder: &Path) -> Result<(String, Issuer<'static, KeyPair>), LabError> {
    let (path, key_path) = (folder.join(AUTHORITY), folder.join(AUTHORITY_KEY));
    if path.exists() || key_path.exists() {
        let (pem, key) = (read(&path)?, read(&key_path)?);
        let key = KeyPair::from_pem(&key)?;
        let issuer = Issuer::from_ca_cert_pem(&pem, key)?;
        return Ok((pem, issuer));
    }
    let key = KeyPair::generate()?;
    let mut params = CertificateParams::default();
    params
        .distinguished_name
        .push(DnType::CommonName, "palpate-link");
    params.is_ca = IsCa::Ca(BasicConstraints::Constrained(0));
    params.key_usages = vec![KeyUsagePurpose::KeyCertSign, KeyUsagePurpose::CrlSign];
    params.not_before = now() - BEFORE;
    params.not_after = now() + Duration::days(AUTHORITY_DAYS);
    let pem = params.self_signed(&key)?.pem();
    write_secret(&key_path, &key.serialize_pem())?;
    write(&path, &pem)?;
    Ok((pem, Issuer::new(params, key)))
}

#[cfg(test)]
#[path = "certificates_tests.rs"]
mod tests;
