#pragma once

#include <chrono>
#include <string>
#include <vector>

#include "base/clock.h"
#include "base/result.h"
#include "base/storage.h"

namespace annulus {

/// The station's own TLS identity: a certificate authority of its own, made at install, and a server certificate by it.
struct TlsIdentity {
  std::string certificate_pem;  ///< Server certificate, then the authority's.
  std::string private_key_pem;  ///< ECDSA P-256.
  std::string authority_pem;    ///< What a remote browser is to trust.
  std::string fingerprint;      ///< SHA-256 of the authority's certificate, "AB:CD:…", to compare by eye.
  std::chrono::sys_seconds not_before;
  std::chrono::sys_seconds not_after;
};

/// Why a certificate cannot be relied on now; empty if it can (fault row N7: expired, or the clock is wrong).
[[nodiscard]] std::string CertificateProblem(const TlsIdentity& identity, std::chrono::sys_seconds now);

/// The identity in `folder`, which is its own (mode 0700; files 0600): made on first use, the server certificate
/// renewed when it has less than a third of its life (397 days) left, has expired, is from the future (the clock was
/// wrong), or lacks one of `host_names` (localhost, 127.0.0.1 and ::1 are always in it). The authority (ten years) and
/// its key stay; by a clock outside its life nothing is renewed. Fails if a host name is none, or if the files cannot
/// be read or do not belong together; never overwrites those.
///
///     authority.pem, authority.key     the authority's certificate and key
///     server.pem                       the server's, both in one file, so that they are replaced together
Result<TlsIdentity> OpenTlsIdentity(Storage& storage, const std::string& folder,
                                    const std::vector<std::string>& host_names, const Clock& clock);

}  // namespace annulus
