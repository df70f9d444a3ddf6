"""A plant for the tests: mosquitto as its broker, and a host that hears all of Sparkplug, decoded by npm's
sparkplug-payload."""
import json
import pathlib
import subprocess
import threading

import paho.mqtt.client as mqtt
from paho.mqtt.packettypes import PacketTypes
from paho.mqtt.properties import Properties

from ports import can_connect, wait_until

HERE = pathlib.Path(__file__).resolve().parent
BROKER = "/usr/sbin/mosquitto"


class Broker:
    """On a port of the loopback; `lines` of its configuration may ask for TLS."""

    def __init__(self, case, folder, port, lines="allow_anonymous true"):
        self.case, self.port = case, port
        self.config = folder / "mosquitto.conf"
        self.config.write_text(f"listener {port} 127.0.0.1\n{lines}\npersistence true\npersistence_location {folder}/\n"
                               "queue_qos0_messages true\nmax_queued_messages 0\nuser root\n"
                               "log_type error\nlog_type warning\nlog_type notice\nlog_type subscribe\n")
        self.log = open(folder / "mosquitto.log", "a+")
        case.addCleanup(self.log.close)
        self.start()

    def start(self):
        self.process = self.case.start([BROKER, "-c", self.config], stderr=self.log, stdout=self.log)
        wait_until(lambda: can_connect(self.port), "the broker's port")

    def stop(self):
        self.process.terminate()
        self.process.wait(20)

    def text(self):
        self.log.seek(0)
        return self.log.read()


class Decoder:
    def __init__(self):
        self.process = subprocess.Popen(["node", HERE / "clients" / "sparkplug_decoder.js"], stdin=subprocess.PIPE,
                                        stdout=subprocess.PIPE, text=True)

    def decode(self, payload):
        print(payload.hex(), file=self.process.stdin, flush=True)
        return json.loads(self.process.stdout.readline())

    def close(self):
        self.process.kill()
        self.process.communicate()


class Message:
    def __init__(self, message, payload):
        _, self.group, self.kind, self.node, *device = message.topic.split("/")
        self.device = device[0] if device else None
        self.qos, self.retained, self.payload = message.qos, message.retain, message.payload
        self.seq, self.time = payload.get("seq"), payload["timestamp"]
        self.metrics = payload["metrics"]

    def __repr__(self):
        return f"{self.kind} {self.device} seq {self.seq}"

    def named(self):
        return {metric["name"]: metric for metric in self.metrics}


class Host:
    """All messages of the group, in the order in which the broker gave them; it comes back when the broker does, which
    keeps meanwhile what it misses."""

    def __init__(self, port, tls=None):
        self.decoder = Decoder()
        self.heard, self.lock = [], threading.Lock()
        self.listening = threading.Event()
        self.client = mqtt.Client(client_id="host", protocol=mqtt.MQTTv5)
        if tls:
            self.client.tls_set(**tls)
        self.client.reconnect_delay_set(1, 1)
        properties = Properties(PacketTypes.CONNECT)
        properties.SessionExpiryInterval = 3600
        self.client.on_connect = lambda client, *_: client.subscribe("spBv1.0/#", qos=1)
        self.client.on_subscribe = lambda *_: self.listening.set()
        self.client.on_message = self._hear
        self.client.connect("127.0.0.1", port, clean_start=False, properties=properties)
        self.client.loop_start()
        assert self.listening.wait(20), "the host hears nothing"

    def _hear(self, _client, _data, message):
        if "/NCMD/" in message.topic:
            return
        decoded = Message(message, self.decoder.decode(message.payload))
        with self.lock:
            self.heard.append(decoded)

    def messages(self, *kinds):
        with self.lock:
            return [message for message in self.heard if not kinds or message.kind in kinds]

    def wait_for(self, kind, count=1, seconds=60.0):
        """The messages of this kind, as soon as there are so many."""
        return wait_until(lambda: len(self.messages(kind)) >= count and self.messages(kind),
                          f"{count} {kind} (heard: {self.messages()[-20:]})", seconds)

    def close(self):
        self.client.loop_stop()
        self.client.disconnect()
        self.decoder.close()
