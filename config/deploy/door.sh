#!/bin/sh
# A door: a small public machine through which people reach robots that dial out to it. On a bare
# Debian 12 or 13 whose name leads to it, as root:
#   sh door.sh robot.example.org             set it up; print the line for the first robot
#   sh door.sh robot-2.example.org           a further robot, by a name of its own
#   sh door.sh --forget robot-2.example.org  its line is worth nothing from now on
# Typed again it changes nothing and prints the same line. README.md says what it opens to whom.
set -eu
umask 022
HOME_DIR=/etc/wax-door
RELAY_PORTS=49152-50151

fail() { echo "door.sh: $*" >&2; exit 1; }
write() { cat >"$1.new" && chmod "${2:-644}" "$1.new" && mv "$1.new" "$1"; }

[ "$(id -u)" = 0 ] || fail "needs root: sudo sh door.sh $*"
forget=
[ "${1-}" != --forget ] || { forget=yes && shift; }
[ $# = 1 ] || fail "usage: sh door.sh [--forget] robot.example.org"
name=$(printf %s "$1" | tr '[:upper:]' '[:lower:]')
case $name in
*[!a-z0-9.-]* | .* | -* | *. | *-) fail "'$1' is no name; write it as robot.example.org" ;;
*.*) ;;
*) fail "'$1' is no whole name; write it as robot.example.org" ;;
esac

robots=$HOME_DIR/robots
mkdir -p "$robots"
chmod 700 "$robots"
if [ "$forget" ]; then
	[ -f "$robots/$name" ] || fail "there is no robot $name here; these are: $(ls "$robots")"
	[ "$name" != "$(cat $HOME_DIR/name)" ] || [ "$(ls "$robots")" = "$name" ] ||
		fail "$name is the door's own name, which the others use; forget them first"
	rm "$robots/$name"
	[ "$(ls "$robots")" ] || rm $HOME_DIR/name
elif ! getent ahosts "$name" >/dev/null; then
	fail "$name has no address yet: let its A (and AAAA) record lead to this machine, then try again"
fi

missing=
for package in openssh-server caddy coturn nftables openssl iproute2 procps; do
	dpkg -s $package >/dev/null 2>&1 || missing="$missing $package"
done
if [ "$missing" ]; then
	apt-get update -qq >&2
	# shellcheck disable=SC2086
	DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends $missing >&2
fi

# Each robot: its port, the seed of its key (RFC 8032), and its secret for the relay.
if [ ! "$forget" ] && [ ! -f "$robots/$name" ]; then
	port=20001
	while grep -qs "^port=$port$" "$robots"/*; do port=$((port + 1)); done
	printf 'port=%s\nseed=%s\nsecret=%s\n' "$port" "$(openssl rand -base64 32)" \
		"$(openssl rand -hex 16)" | write "$robots/$name" 600
fi
[ "$forget" ] || [ -f $HOME_DIR/name ] || echo "$name" >$HOME_DIR/name
door=$(cat $HOME_DIR/name 2>/dev/null || true)

# --- sshd: one user, who may do nothing but let a port of this machine lead to its robot --------
# What a Match block says goes before what stands without one, so a hardened sshd lets robots in, too.
id wax-door >/dev/null 2>&1 ||
	useradd --system --user-group --no-create-home --home-dir /nonexistent \
		--shell /usr/sbin/nologin --password '*' wax-door
RULES=/etc/ssh/sshd_config.d/wax-door.conf
HOST_KEY=/etc/ssh/ssh_host_ed25519_key
[ -f $HOST_KEY ] || ssh-keygen -q -t ed25519 -N '' -f $HOST_KEY
write $RULES <<'END'
Match User wax-door
	AllowUsers wax-door
	AllowGroups *
	AuthenticationMethods publickey
	PubkeyAuthentication yes
	PubkeyAcceptedAlgorithms ssh-ed25519
	AuthorizedKeysFile /etc/wax-door/authorized_keys
	DisableForwarding no
	AllowTcpForwarding remote
	AllowStreamLocalForwarding no
	AllowAgentForwarding no
	GatewayPorts no
	PermitListen any
	PermitOpen none
	PermitTTY no
	PermitTunnel no
	X11Forwarding no
	MaxSessions 0
	ForceCommand /usr/sbin/nologin
	Banner none
	ClientAliveInterval 2
	ClientAliveCountMax 3
Match all
END
objections() { # of sshd to robots; what `sshd -T` prints for their user is read
	said=$(cat)
	[ "$said" ] || return 0 # sshd itself has said why
	has() { printf '%s\n' "$said" | grep -qixF -- "$1"; }
	if ! has "AuthorizedKeysFile $HOME_DIR/authorized_keys" && ! has 'ForceCommand /usr/sbin/nologin'; then
		echo "it does not read $RULES: let the first line of /etc/ssh/sshd_config be" \
			"'Include /etc/ssh/sshd_config.d/*.conf'"
	else
		while read -r key value; do
			[ "$key" = Match ] || has "$key $value" ||
				echo "it follows another line with $key than that in $RULES: grep -rin $key /etc/ssh"
		done <$RULES
	fi
	printf '%s\n' "$said" | grep -i '^deny' | while read -r key pattern; do
		# shellcheck disable=SC2254
		case wax-door in
		${pattern%@*}) echo "its $key $pattern means wax-door, too: grep -rin $key /etc/ssh" ;;
		esac
	done
	has "HostKey $HOST_KEY" || echo "it does not use $HOST_KEY: add the line 'HostKey $HOST_KEY'"
	printf '%s\n' "$said" | grep -qiE '^hostkeyalgorithms (.*,)?ssh-ed25519(,|$)' ||
		echo "its HostKeyAlgorithms leave out ssh-ed25519: grep -rin HostKeyAlgorithms /etc/ssh"
}
public() { # of the robot with this seed, as OpenSSH writes it
	{
		printf '\000\000\000\013ssh-ed25519\000\000\000\040'
		{ printf '\060\056\002\001\000\060\005\006\003\053\145\160\004\042\004\040' &&
			echo "$1" | base64 -d; } |
			openssl pkey -inform DER -pubout -outform DER | tail -c 32
	} | base64 -w 0
}
for robot in "$robots"/*; do
	[ -f "$robot" ] || continue
	port=0 seed=''
	# shellcheck disable=SC1090
	. "$robot"
	echo "restrict,port-forwarding,permitlisten=\"127.0.0.1:$port\" ssh-ed25519 $(public "$seed") ${robot##*/}"
done | write $HOME_DIR/authorized_keys

# The same by TCP 443, for networks that let out nothing else: Caddy hands it on to this.
write /usr/local/lib/wax-door-ssh 755 <<'END'
#!/bin/sh
while IFS= read -r line && [ "$line" != "$(printf '\r')" ]; do :; done
printf 'HTTP/1.1 101 Switching Protocols\r\nConnection: Upgrade\r\nUpgrade: ssh\r\n\r\n'
exec /usr/sbin/sshd -i -o LoginGraceTime=10
END
write /etc/systemd/system/wax-door-ssh.socket <<'END'
[Socket]
ListenStream=127.0.0.1:20000
Accept=yes
MaxConnections=32

[Install]
WantedBy=sockets.target
END
write /etc/systemd/system/wax-door-ssh@.service <<'END'
[Service]
ExecStart=-/usr/local/lib/wax-door-ssh
StandardInput=socket
StandardError=journal
RuntimeDirectory=sshd
RuntimeDirectoryPreserve=yes
RuntimeDirectoryMode=0755
END

# --- Caddy: each robot's page by HTTPS, with a certificate that it gets by itself ------------------
if [ -f /etc/caddy/Caddyfile ] && ! grep -q '^# Written by door.sh' /etc/caddy/Caddyfile; then
	cp /etc/caddy/Caddyfile /etc/caddy/Caddyfile.before-door
fi
{
	echo '# Written by door.sh'
	for robot in "$robots"/*; do
		[ -f "$robot" ] || continue
		# shellcheck disable=SC1090
		. "$robot"
		cat <<END
${robot##*/} {
	@ssh {
		path /wax-door
		header Upgrade ssh
	}
	handle @ssh {
		reverse_proxy 127.0.0.1:20000
	}
	handle /wax-door {
		respond 426
	}
	handle {
		request_body {
			max_size 64KB
		}
		reverse_proxy 127.0.0.1:$port {
			header_up -Forwarded
			transport http {
				dial_timeout 2s
				response_header_timeout 15s
			}
		}
	}
	handle_errors {
		respond "This robot is not connected just now. Try again in a moment." {err.status_code}
	}
}
END
	done
} | write /etc/caddy/Caddyfile

# --- coturn: tells addresses (STUN), and relays between those whom a robot gave a password --------
# Both ends of a relayed connection are relayed here, so the relay need reach nobody but itself:
# coturn is held to this machine's addresses, and by nftables to its own ports there.
{
	echo "realm=${door:-nobody}"
	for robot in "$robots"/*; do
		[ -f "$robot" ] || continue
		# shellcheck disable=SC1090
		. "$robot"
		echo "static-auth-secret=$secret"
	done
	cat <<END
use-auth-secret
fingerprint
stale-nonce=600
denied-peer-ip=0.0.0.0-255.255.255.255
denied-peer-ip=::-ffff:ffff:ffff:ffff:ffff:ffff:ffff:ffff
no-multicast-peers
no-tcp-relay
no-tlsv1
no-tlsv1_1
user-quota=4
total-quota=1000
max-bps=500000
min-port=${RELAY_PORTS%-*}
max-port=${RELAY_PORTS#*-}
no-cli
no-rfc5780
no-stun-backward-compatibility
response-origin-only-with-rfc5780
simple-log
log-file=stdout
cert=/etc/wax-door/relay.crt
pkey=/etc/wax-door/relay.key
END
	own=$(ip -o address show scope global | awk '{ sub("/.*", "", $4); print $4 }')
	for address in $own; do echo "allowed-peer-ip=$address"; done
	for address in $(getent ahostsv4 "${door:-localhost}" | awk '{ print $1 }' | sort -u); do
		case " $(echo $own) " in
		*" $address "*) ;;
		*) # a cloud's: the world knows this machine by another address than its own
			echo "allowed-peer-ip=$address"
			echo "external-ip=$address/$(echo "$own" | grep -m 1 -v :)"
			;;
		esac
	done
} | write /etc/turnserver.conf 640
chgrp turnserver /etc/turnserver.conf
write $HOME_DIR/relay.nft <<END
table inet wax_door
delete table inet wax_door
table inet wax_door {
	chain output {
		type filter hook output priority filter
		meta skuid turnserver udp sport $RELAY_PORTS udp dport != $RELAY_PORTS drop
	}
}
END
# Debian's caddy stays away once it was killed, as for want of memory, and its coturn ends for good
# where the network comes up after it.
mkdir -p /etc/systemd/system/caddy.service.d /etc/systemd/system/coturn.service.d
write /etc/systemd/system/caddy.service.d/wax-door.conf <<'END'
[Service]
Restart=on-failure
RestartSec=3
END
write /etc/systemd/system/coturn.service.d/wax-door.conf <<'END'
[Unit]
Wants=network-online.target
After=network-online.target

[Service]
ExecStartPre=+/usr/sbin/nft -f /etc/wax-door/relay.nft
Restart=on-failure
RestartSec=3
END
# Caddy's certificate, for the relay by TLS: copied once there is one, and when it is a new one.
write /usr/local/lib/wax-door-certificate 755 <<'END'
#!/bin/sh
set -eu
name=$(cat /etc/wax-door/name)
found=$(ls -t /var/lib/caddy/.local/share/caddy/certificates/*/"$name/$name.crt" 2>/dev/null | head -n 1)
[ "$found" ] || exit 1 # systemd tries again
! cmp -s "$found" /etc/wax-door/relay.crt || exit 0
how=restart
[ ! -f /etc/wax-door/relay.crt ] || how='kill -s USR2' # it reads a renewed one, and relays on
install -m 640 -g turnserver "$found" /etc/wax-door/relay.crt
install -m 640 -g turnserver "${found%.crt}.key" /etc/wax-door/relay.key
# shellcheck disable=SC2086
systemctl $how coturn
END
write /etc/systemd/system/wax-door-certificate.service <<'END'
[Service]
Type=oneshot
ExecStart=/usr/local/lib/wax-door-certificate
Restart=on-failure
RestartSec=20
END
write /etc/systemd/system/wax-door-certificate.timer <<'END'
[Timer]
OnActiveSec=20
OnUnitActiveSec=1h

[Install]
WantedBy=timers.target
END

mkdir -p /run/sshd
/usr/sbin/sshd -t
systemctl daemon-reload
systemctl enable --quiet --now ssh wax-door-ssh.socket caddy coturn wax-door-certificate.timer
systemctl reload ssh caddy
systemctl restart coturn wax-door-certificate.timer
if [ "$forget" ]; then
	pkill -u wax-door sshd || true # the others come back by themselves
	echo "$name is forgotten." >&2
	exit
fi

# shellcheck disable=SC1090
. "$robots/$name"
host=$(cut -d ' ' -f 2 $HOST_KEY.pub | base64 -d | tail -c 32 | base64 -w 0)
body="wax-door-1:$door:$name:$port:$host:$seed:$secret"
for way in addr=192.0.2.1,laddr=192.0.2.2,lport=22 addr=127.0.0.1,laddr=127.0.0.1,lport=20000; do
	/usr/sbin/sshd -T -C user=wax-door,host=robot.invalid,$way | objections
done | sort -u | sed 's/^/door.sh: sshd is not as robots need it: /' >&2
echo "Robots reach this machine by TCP 22 or 443; let in TCP 80, 3478, 5349, UDP 3478 and $RELAY_PORTS too." >&2
echo "On the robot: wax init --door LINE, where LINE, which is a secret, is:" >&2
printf '%s:%s\n' "$body" "$(printf %s "$body" | sha256sum | cut -c 1-8)"
