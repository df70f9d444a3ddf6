"""A capture file of Modbus/TCP before Wireshark's dissector."""
import collections
import subprocess

FIELDS = ("frame.number", "tcp.stream", "tcp.srcport", "mbtcp.trans_id", "mbtcp.len", "modbus.func_code",
          "modbus.exception_code", "modbus.request_frame", "_ws.malformed", "_ws.expert.severity", "_ws.expert.message")
SERVER_PORT = "502"
WARNING = 0x00600000  # errors are above; below are notes and chat, which say that a connection begins or ends
LONGEST = 254  # a longer one is no Modbus; the server ends the connection

Frame = collections.namedtuple("Frame", "number stream port transaction length function exception asked_in malformed "
                                        "severity message")


def frames(path):
    """The frames that carry Modbus or that the dissector has something to say of."""
    command = ["tshark", "-n", "-r", path, "-T", "fields", "-E", "separator=|", "-E", "aggregator=;"]
    for field in FIELDS:
        command += ["-e", field]
    shown = subprocess.run(command, capture_output=True, text=True, timeout=120)
    if shown.returncode != 0:
        raise AssertionError(shown.stderr)
    return [Frame(*line.split("|", len(FIELDS) - 1)) for line in shown.stdout.splitlines()]


def judge(path):
    """How many answers the server gave, and what is wrong with them or with the requests: frames that are malformed or
    carry a warning, answers to nothing, requests without an answer."""
    answers, complaints, waiting = 0, [], collections.defaultdict(list)
    for frame in frames(path):
        severities = [int(severity) for severity in frame.severity.split(";") if severity]
        if frame.malformed or any(severity >= WARNING for severity in severities):
            complaints.append(f"frame {frame.number}: {frame.message or 'malformed'}")
        if not frame.transaction:
            continue
        told = list(zip(*(field.split(";") for field in (frame.transaction, frame.function, frame.length))))
        if frame.port != SERVER_PORT:
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
