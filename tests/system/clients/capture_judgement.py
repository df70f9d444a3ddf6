"""A capture file of Modbus/TCP before Wireshark's dissector.

capture_judgement.py FILE: says what is wrong with what the servers in it answered, whatever their ports.
"""
import collections
import subprocess
import sys

FIELDS = ("frame.number", "tcp.stream", "tcp.srcport", "mbtcp.trans_id", "mbtcp.len", "modbus.func_code",
          "modbus.exception_code", "modbus.request_frame", "_ws.malformed", "_ws.expert.severity", "_ws.expert.message")
WARNING = 0x00600000  # errors are above; below are notes and chat, which say that a connection begins or ends
LONGEST = 254  # a longer one is no Modbus; the server ends the connection

Frame = collections.namedtuple("Frame", "number stream port transaction length function exception asked_in malformed "
                                        "severity message")


def tshark(path, *options):
    shown = subprocess.run(["tshark", "-n", "-r", path, *options], capture_output=True, text=True, timeout=600)
    if shown.returncode != 0:
        raise AssertionError(shown.stderr)
    return shown.stdout.splitlines()


def servers(path):
    """The port that each connection went to."""
    beginnings = tshark(path, "-Y", "tcp.flags.syn == 1 && tcp.flags.ack == 0", "-T", "fields", "-e", "tcp.stream",
                        "-e", "tcp.dstport")
    return dict(line.split() for line in beginnings)


def frames(path, ports):
    columns = [option for field in FIELDS for option in ("-e", field)]
    lines = tshark(path, "-o", f"mbtcp.tcp.port:{','.join(sorted(set(ports), key=int))}", "-T", "fields",
                   "-E", "separator=|", "-E", "aggregator=;", *columns)
    return [Frame(*line.split("|", len(FIELDS) - 1)) for line in lines]


def judge(path):
    """How many answers the servers gave, and what is wrong with them or with the requests: frames that are malformed or
    carry a warning, answers to nothing, requests without an answer."""
    answers, complaints, waiting = 0, [], collections.defaultdict(list)
    server_of = servers(path)
    for frame in frames(path, server_of.values()):
        severities = [int(severity) for severity in frame.severity.split(";") if severity]
        if frame.malformed or (frame.transaction and any(severity >= WARNING for severity in severities)):
            complaints.append(f"frame {frame.number}: {frame.message or 'malformed'}")
        if not frame.transaction:
            continue
        told = list(zip(*(field.split(";") for field in (frame.transaction, frame.function, frame.length))))
        if frame.port != server_of.get(frame.stream):
            waiting[frame.stream] += [each[:2] for each in told if int(each[2]) <= LONGEST]
            continue
        for transaction, function, _ in told:
            answers += 1
            asked = waiting[frame.stream]
            if not asked or asked.pop(0) != (transaction, function):
                complaints.append(f"frame {frame.number}: an answer to nothing")
        if not frame.exception and not frame.asked_in:
            complaints.append(f"frame {frame.number}: the dissector finds no request to this answer")
    complaints += [f"connection {stream}: no answer to {asked}" for stream, asked in waiting.items() if asked]
    return answers, complaints


if __name__ == "__main__":
    ANSWERS, COMPLAINTS = judge(sys.argv[1])
    print(f"{ANSWERS} answers, {len(COMPLAINTS)} complaints", *COMPLAINTS, sep="\n")
    sys.exit(1 if COMPLAINTS else 0)
