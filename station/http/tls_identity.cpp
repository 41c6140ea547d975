#include "station/http/tls_identity.h"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <openssl/bio.h>
#include <openssl/err.h>
#include <openssl/evp.h>
#include <openssl/pem.h>
#include <openssl/rand.h>
#include <openssl/x509.h>
#include <openssl/x509v3.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <ctime>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <utility>

namespace annulus {
namespace {

using std::chrono::days;
using std::chrono::sys_seconds;

struct Free {
  void operator()(ASN1_OCTET_STRING* text) const { ASN1_OCTET_STRING_free(text); }
  void operator()(BIGNUM* number) const { BN_free(number); }
  void operator()(BIO* bio) const { BIO_free(bio); }
  void operator()(EVP_PKEY* key) const { EVP_PKEY_free(key); }
  void operator()(GENERAL_NAMES* names) const { GENERAL_NAMES_free(names); }
  void operator()(X509* certificate) const { X509_free(certificate); }
  void operator()(X509_EXTENSION* extension) const { X509_EXTENSION_free(extension); }
};
template <class T>
using Owned = std::unique_ptr<T, Free>;

/// The authority outlives the machine's use; browsers take no server certificate of more than 398 days.
constexpr days kAuthorityLife{3650};
constexpr days kServerLife{397};
/// Clocks of browsers may be behind ours.
constexpr std::chrono::hours kBackdate{24};
constexpr std::uint64_t kMaxFileBytes = 64 << 10;
/// Of a serial number: 127 random bits (CA/Browser Forum baseline requirements §7.1 ask for 64).
constexpr int kSerialBits = 127;
constexpr char kOrganisation[] = "annulus measurement station";

constexpr char kAuthorityFile[] = "/authority.pem";
constexpr char kAuthorityKeyFile[] = "/authority.key";
constexpr char kServerFile[] = "/server.pem";

tl::unexpected<Error> FailOpenssl(const std::string& attempted) {
  const unsigned long code = ERR_get_error();
  ERR_clear_error();
  const char* reason = code == 0 ? nullptr : ERR_reason_error_string(code);
  return Fail(attempted, reason == nullptr ? "OpenSSL refuses it" : reason, "check the OpenSSL of this machine");
}

tl::unexpected<Error> FailFiles(const std::string& folder, const std::string& seen) {
  return Fail("open the station's TLS identity in " + folder, seen,
              "restore the folder from a backup; or, to have a new authority that all browsers must be told to trust "
              "again, move the folder away");
}

// Keys and certificates as PEM.

Owned<BIO> Reader(const std::string& pem) {
  return Owned<BIO>(BIO_new_mem_buf(pem.data(), static_cast<int>(pem.size())));
}

std::string TextOf(BIO* bio) {
  char* bytes = nullptr;
  const long length = BIO_get_mem_data(bio, &bytes);
  return length <= 0 ? std::string() : std::string(bytes, static_cast<std::size_t>(length));
}

Owned<X509> CertificateFromPem(const std::string& pem) {
  return Owned<X509>(PEM_read_bio_X509(Reader(pem).get(), nullptr, nullptr, nullptr));
}

Owned<EVP_PKEY> KeyFromPem(const std::string& pem) {
  // No password is asked for on the terminal.
  const auto no_password = [](char*, int, int, void*) { return -1; };
  return Owned<EVP_PKEY>(PEM_read_bio_PrivateKey(Reader(pem).get(), nullptr, no_password, nullptr));
}

std::string PemOf(X509& certificate) {
  const Owned<BIO> bio(BIO_new(BIO_s_mem()));
  return PEM_write_bio_X509(bio.get(), &certificate) == 1 ? TextOf(bio.get()) : std::string();
}

std::string PemOf(EVP_PKEY& key) {
  // In OpenSSL's secure memory if there is any; wiped when it is freed.
  const Owned<BIO> bio(BIO_new(BIO_s_secmem()));
  const int written = PEM_write_bio_PKCS8PrivateKey(bio.get(), &key, nullptr, nullptr, 0, nullptr, nullptr);
  return written == 1 ? TextOf(bio.get()) : std::string();
}

// Certificates.

struct KeyedCertificate {
  Owned<EVP_PKEY> key;
  Owned<X509> certificate;
};

bool Fits(const KeyedCertificate& pair) { return X509_check_private_key(pair.certificate.get(), pair.key.get()) == 1; }

bool AddExtension(X509& certificate, X509& issuer, int kind, const std::string& value) {
  X509V3_CTX context;
  X509V3_set_ctx_nodb(&context);
  X509V3_set_ctx(&context, &issuer, &certificate, nullptr, nullptr, 0);
  const Owned<X509_EXTENSION> extension(X509V3_EXT_conf_nid(nullptr, &context, kind, value.c_str()));
  return extension && X509_add_ext(&certificate, extension.get(), -1) == 1;
}

bool SetSerial(X509& certificate) {
  const Owned<BIGNUM> number(BN_new());
  return BN_rand(number.get(), kSerialBits, BN_RAND_TOP_ONE, BN_RAND_BOTTOM_ANY) == 1 &&
         BN_to_ASN1_INTEGER(number.get(), X509_get_serialNumber(&certificate)) != nullptr;
}

bool SetName(X509& certificate, const std::string& common_name) {
  const auto add = [&](const char* field, const char* text) {
    return X509_NAME_add_entry_by_txt(X509_get_subject_name(&certificate), field, MBSTRING_UTF8,
                                      reinterpret_cast<const unsigned char*>(text), -1, -1, 0) == 1;
  };
  return add("O", kOrganisation) && add("CN", common_name.c_str());
}

bool SetLife(X509& certificate, sys_seconds from, sys_seconds to) {
  return ASN1_TIME_set(X509_getm_notBefore(&certificate), from.time_since_epoch().count()) != nullptr &&
         ASN1_TIME_set(X509_getm_notAfter(&certificate), to.time_since_epoch().count()) != nullptr;
}

/// A certificate for `key`, not yet signed and without extensions.
Owned<X509> Draft(EVP_PKEY& key, const std::string& common_name, sys_seconds from, sys_seconds to) {
  Owned<X509> certificate(X509_new());
  constexpr long kVersion3 = 2;
  const bool made = certificate && X509_set_version(certificate.get(), kVersion3) == 1 && SetSerial(*certificate) &&
                    SetName(*certificate, common_name) && SetLife(*certificate, from, to) &&
                    X509_set_pubkey(certificate.get(), &key) == 1;
  return made ? std::move(certificate) : nullptr;
}

/// `key`: null for a new one.
Result<KeyedCertificate> MakeAuthority(Owned<EVP_PKEY> key, sys_seconds now) {
  const std::string attempted = "make the station's certificate authority";
  KeyedCertificate made{key ? std::move(key) : Owned<EVP_PKEY>(EVP_EC_gen("P-256")), nullptr};
  if (!made.key) return FailOpenssl(attempted);
  // Its name tells one station's authority from another's in a browser's list.
  std::array<unsigned char, 4> random{};
  if (RAND_bytes(random.data(), static_cast<int>(random.size())) != 1) return FailOpenssl(attempted);
  const std::string name =
      fmt::format("annulus station authority {:02x}{:02x}{:02x}{:02x}", random[0], random[1], random[2], random[3]);
  made.certificate = Draft(*made.key, name, now - kBackdate, now + kAuthorityLife);
  if (!made.certificate) return FailOpenssl(attempted);
  X509& certificate = *made.certificate;
  const bool signed_ = X509_set_issuer_name(&certificate, X509_get_subject_name(&certificate)) == 1 &&
                       AddExtension(certificate, certificate, NID_basic_constraints, "critical,CA:TRUE,pathlen:0") &&
                       AddExtension(certificate, certificate, NID_key_usage, "critical,keyCertSign,cRLSign") &&
                       AddExtension(certificate, certificate, NID_subject_key_identifier, "hash") &&
                       X509_sign(&certificate, made.key.get(), EVP_sha256()) > 0;
  if (!signed_) return FailOpenssl(attempted);
  return made;
}

/// Sixteen or four bytes of a numeric address; empty if `name` is none.
std::string AddressBytes(const std::string& name) {
  std::array<char, sizeof(in6_addr)> bytes{};
  if (::inet_pton(AF_INET, name.c_str(), bytes.data()) == 1) return {bytes.data(), sizeof(in_addr)};
  if (::inet_pton(AF_INET6, name.c_str(), bytes.data()) == 1) return {bytes.data(), sizeof(in6_addr)};
  return {};
}

bool IsHostName(const std::string& name) {
  constexpr std::size_t kMaxBytes = 253;
  const bool letters =
      name.find_first_not_of("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789-.") == std::string::npos;
  return !name.empty() && name.size() <= kMaxBytes && letters && name.front() != '.' && name.front() != '-';
}

/// As X509V3_EXT_conf_nid takes them.
std::string AlternativeNames(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) {
    text += text.empty() ? "" : ",";
    text += (AddressBytes(name).empty() ? "DNS:" : "IP:") + name;
  }
  return text;
}

Result<KeyedCertificate> MakeServer(const KeyedCertificate& authority, const std::vector<std::string>& names,
                                    sys_seconds now) {
  const std::string attempted = "make the station's server certificate";
  KeyedCertificate made{Owned<EVP_PKEY>(EVP_EC_gen("P-256")), nullptr};
  if (!made.key) return FailOpenssl(attempted);
  made.certificate = Draft(*made.key, names.front(), now - kBackdate, now + kServerLife);
  if (!made.certificate) return FailOpenssl(attempted);
  X509& certificate = *made.certificate;
  X509& issuer = *authority.certificate;
  const bool signed_ = X509_set_issuer_name(&certificate, X509_get_subject_name(&issuer)) == 1 &&
                       AddExtension(certificate, issuer, NID_basic_constraints, "critical,CA:FALSE") &&
                       AddExtension(certificate, issuer, NID_key_usage, "critical,digitalSignature") &&
                       AddExtension(certificate, issuer, NID_ext_key_usage, "serverAuth") &&
                       AddExtension(certificate, issuer, NID_subject_alt_name, AlternativeNames(names)) &&
                       AddExtension(certificate, issuer, NID_subject_key_identifier, "hash") &&
                       AddExtension(certificate, issuer, NID_authority_key_identifier, "keyid:always") &&
                       X509_sign(&certificate, authority.key.get(), EVP_sha256()) > 0;
  if (!signed_) return FailOpenssl(attempted);
  return made;
}

// What a certificate says.

sys_seconds TimeOf(const ASN1_TIME* time) {
  std::tm parts{};
  if (ASN1_TIME_to_tm(time, &parts) != 1) return {};
  const std::chrono::year_month_day date(std::chrono::year(parts.tm_year + 1900),
                                         std::chrono::month(static_cast<unsigned>(parts.tm_mon + 1)),
                                         std::chrono::day(static_cast<unsigned>(parts.tm_mday)));
  return std::chrono::sys_days(date) + std::chrono::hours(parts.tm_hour) + std::chrono::minutes(parts.tm_min) +
         std::chrono::seconds(parts.tm_sec);
}

std::string FingerprintOf(const X509& certificate) {
  std::array<unsigned char, EVP_MAX_MD_SIZE> digest{};
  unsigned int length = 0;
  std::string text;
  if (X509_digest(&certificate, EVP_sha256(), digest.data(), &length) != 1) return text;
  for (unsigned int i = 0; i < length; ++i) text += fmt::format("{}{:02X}", i == 0 ? "" : ":", digest[i]);
  return text;
}

bool HasName(X509& certificate, const std::string& name) {
  if (!AddressBytes(name).empty()) return X509_check_ip_asc(&certificate, name.c_str(), 0) == 1;
  return X509_check_host(&certificate, name.c_str(), name.size(), X509_CHECK_FLAG_NEVER_CHECK_SUBJECT, nullptr) == 1;
}

bool NeedsRenewal(const X509& authority, X509& server, const std::vector<std::string>& names, sys_seconds now) {
  const sys_seconds from = TimeOf(X509_get0_notBefore(&server));
  const sys_seconds to = TimeOf(X509_get0_notAfter(&server));
  // By a clock outside the authority's life nothing good can be made; CertificateProblem tells.
  const bool plausible = now >= TimeOf(X509_get0_notBefore(&authority)) && now < TimeOf(X509_get0_notAfter(&authority));
  const bool old = to - now < (to - from) / 3;
  const bool made_ahead = now < from;  // when the clock was wrong
  const bool nameless = std::any_of(names.begin(), names.end(), [&](const auto& n) { return !HasName(server, n); });
  return nameless || (plausible && (old || made_ahead));
}

// Files.

/// For the owner only, before the first byte is in it. A storage that is no file system has no modes.
Status Restrict(const std::string& path, std::filesystem::perms mode) {
  std::error_code error;
  std::filesystem::permissions(path, mode, error);
  if (!error || error == std::errc::no_such_file_or_directory) return {};
  return Fail("keep " + path + " from others", error.message(), "put it on a disk with file permissions");
}

constexpr auto kOwnerReadsWrites = std::filesystem::perms::owner_read | std::filesystem::perms::owner_write;

Status WritePrivately(Storage& storage, const std::string& path, const std::string& text) {
  const std::string temporary = TemporaryName(path);
  if (storage.Exists(temporary)) RETURN_IF_ERROR(storage.Remove(temporary));
  const auto write = [&]() -> Status {
    auto file = storage.Create(temporary);
    if (!file) return Fail(file);
    RETURN_IF_ERROR(Restrict(temporary, kOwnerReadsWrites));
    RETURN_IF_ERROR((*file)->Append(std::as_bytes(std::span(text.data(), text.size()))));
    RETURN_IF_ERROR((*file)->Sync());
    RETURN_IF_ERROR((*file)->Close());
    return storage.Rename(temporary, path);
  };
  Status status = write();
  if (!status && storage.Exists(temporary)) (void)storage.Remove(temporary);
  return status;
}

Result<std::string> ReadPem(Storage& storage, const std::string& path) {
  auto bytes = storage.ReadAll(path, kMaxFileBytes);
  if (!bytes) return Fail(bytes);
  return std::string(reinterpret_cast<const char*>(bytes->data()), bytes->size());
}

/// The authority of a folder that has no certificate of it: new. A key without one is left from a start that was cut
/// short; it is as good as another.
Result<KeyedCertificate> BeginAuthority(Storage& storage, const std::string& folder, sys_seconds now) {
  const std::string key_path = folder + kAuthorityKeyFile;
  if (storage.Exists(folder + kServerFile)) return FailFiles(folder, "authority.pem is missing");
  Owned<EVP_PKEY> key;
  if (storage.Exists(key_path)) {
    auto pem = ReadPem(storage, key_path);
    if (!pem) return Fail(pem);
    key = KeyFromPem(*pem);
    ERR_clear_error();
    if (!key) return FailFiles(folder, "authority.key is no private key");
  }
  const bool new_key = !key;
  auto made = MakeAuthority(std::move(key), now);
  if (!made) return Fail(made);
  if (new_key) RETURN_IF_ERROR(WritePrivately(storage, key_path, PemOf(*made->key)));
  RETURN_IF_ERROR(WritePrivately(storage, folder + kAuthorityFile, PemOf(*made->certificate)));
  return made;
}

Result<KeyedCertificate> OpenAuthority(Storage& storage, const std::string& folder, sys_seconds now) {
  if (!storage.Exists(folder + kAuthorityFile)) return BeginAuthority(storage, folder, now);
  if (!storage.Exists(folder + kAuthorityKeyFile)) return FailFiles(folder, "authority.key is missing");
  auto certificate = ReadPem(storage, folder + kAuthorityFile);
  if (!certificate) return Fail(certificate);
  auto key = ReadPem(storage, folder + kAuthorityKeyFile);
  if (!key) return Fail(key);
  KeyedCertificate opened{KeyFromPem(*key), CertificateFromPem(*certificate)};
  ERR_clear_error();
  if (!opened.certificate) return FailFiles(folder, "authority.pem is no certificate");
  if (!opened.key) return FailFiles(folder, "authority.key is no private key");
  if (!Fits(opened)) return FailFiles(folder, "authority.key does not fit authority.pem");
  return opened;
}

/// The server's certificate and key, from one file so that they can be replaced at once. Nothing if there is none.
Result<std::optional<KeyedCertificate>> ReadServer(Storage& storage, const std::string& folder,
                                                   const KeyedCertificate& authority) {
  const std::string path = folder + kServerFile;
  if (!storage.Exists(path)) return std::optional<KeyedCertificate>();
  auto pem = ReadPem(storage, path);
  if (!pem) return Fail(pem);
  KeyedCertificate opened{KeyFromPem(*pem), CertificateFromPem(*pem)};
  ERR_clear_error();
  if (!opened.key || !opened.certificate) return FailFiles(folder, "server.pem is no certificate with its key");
  if (!Fits(opened)) return FailFiles(folder, "the key in server.pem does not fit its certificate");
  const bool ours = X509_verify(opened.certificate.get(), authority.key.get()) == 1;
  ERR_clear_error();
  if (!ours) return FailFiles(folder, "server.pem was not signed by authority.pem");
  return std::optional<KeyedCertificate>(std::move(opened));
}

/// What is always in the certificate, then the others, each once.
Result<std::vector<std::string>> AllNames(const std::vector<std::string>& host_names) {
  std::vector<std::string> names{"localhost", "127.0.0.1", "::1"};
  for (const std::string& name : host_names) {
    if (AddressBytes(name).empty() && !IsHostName(name)) {
      return Fail("make the station's server certificate", "'" + name + "' is no host name and no address",
                  "give names as booth.example or numeric addresses");
    }
    if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
  }
  return names;
}

TlsIdentity Describe(const KeyedCertificate& authority, const KeyedCertificate& server) {
  TlsIdentity identity;
  identity.authority_pem = PemOf(*authority.certificate);
  identity.certificate_pem = PemOf(*server.certificate) + identity.authority_pem;
  identity.private_key_pem = PemOf(*server.key);
  identity.fingerprint = FingerprintOf(*authority.certificate);
  // Valid as long as both are.
  identity.not_before = std::max(TimeOf(X509_get0_notBefore(server.certificate.get())),
                                 TimeOf(X509_get0_notBefore(authority.certificate.get())));
  identity.not_after = std::min(TimeOf(X509_get0_notAfter(server.certificate.get())),
                                TimeOf(X509_get0_notAfter(authority.certificate.get())));
  return identity;
}

std::string DateOf(sys_seconds time) {
  const std::chrono::year_month_day date(std::chrono::floor<days>(time));
  return fmt::format("{:04}-{:02}-{:02}", static_cast<int>(date.year()), static_cast<unsigned>(date.month()),
                     static_cast<unsigned>(date.day()));
}

}  // namespace

std::string CertificateProblem(const TlsIdentity& identity, sys_seconds now) {
  if (now < identity.not_before) {
    return fmt::format("the certificate is valid from {} on, and this machine's clock says {}: set the clock",
                       DateOf(identity.not_before), DateOf(now));
  }
  if (now >= identity.not_after) {
    return fmt::format(
        "the certificate ended on {}, and this machine's clock says {}: set the clock; if it is right, start "
        "the console again, which renews the certificate",
        DateOf(identity.not_after), DateOf(now));
  }
  return {};
}

Result<TlsIdentity> OpenTlsIdentity(Storage& storage, const std::string& folder,
                                    const std::vector<std::string>& host_names, const Clock& clock) {
  const auto now = sys_seconds(std::chrono::floor<std::chrono::seconds>(clock.WallNow()));
  auto names = AllNames(host_names);
  if (!names) return Fail(names);
  RETURN_IF_ERROR(storage.CreateFolder(folder));
  RETURN_IF_ERROR(Restrict(folder, std::filesystem::perms::owner_all));
  auto authority = OpenAuthority(storage, folder, now);
  if (!authority) return Fail(authority);
  auto server = ReadServer(storage, folder, *authority);
  if (!server) return Fail(server);
  if (!*server || NeedsRenewal(*authority->certificate, *(*server)->certificate, *names, now)) {
    auto made = MakeServer(*authority, *names, now);
    if (!made) return Fail(made);
    RETURN_IF_ERROR(WritePrivately(storage, folder + kServerFile, PemOf(*made->certificate) + PemOf(*made->key)));
    *server = std::move(*made);
  }
  return Describe(*authority, **server);
}

}  // namespace annulus
