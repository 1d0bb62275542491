#!/usr/bin/env python3
"""Send a campaign, record or bench result; read the answer; try again where that can help. Needs Python 3 alone.

    GYROWATCH_URL=http://127.0.0.1:8080 GYROWATCH_TOKEN=... python3 post.py campaign.json

Ends with 0 where the service has it (sending twice is harmless), with 1 where the file is at fault.
"""
import json
import os
import sys
import time
import urllib.error
import urllib.request


def kind_of(text):
    """Path and content type of a document."""
    if not text.lstrip().startswith("{"):
        return "/v1/campaigns", "text/csv"
    members = json.loads(text)
    path = "campaigns" if "dwells" in members else "records" if "gyros" in members else "bench-results"
    return "/v1/" + path, "application/json"


def send(url, token, body):
    """Status, answer, and for how many seconds the service asks to wait."""
    path, content_type = kind_of(body.decode("utf-8-sig"))
    request = urllib.request.Request(url + path, data=body, headers={"Content-Type": content_type})
    if token:
        request.add_header("Authorization", "Bearer " + token)
    try:
        with urllib.request.urlopen(request, timeout=120) as answer:
            return answer.status, json.load(answer), 0
    except urllib.error.HTTPError as refused:
        text = refused.read()
        try:
            problem = json.loads(text)
        except ValueError:
            problem = {"detail": text.decode(errors="replace")[:200]}
        return refused.code, problem, float(refused.headers.get("Retry-After") or 0)


def main():
    url = os.environ.get("GYROWATCH_URL", "http://127.0.0.1:8080").rstrip("/")
    token = os.environ.get("GYROWATCH_TOKEN")
    with open(sys.argv[1], "rb") as file:
        body = file.read()
    pause = 1.0
    while True:
        try:
            status, answer, asked = send(url, token, body)
        except OSError as error:
            status, answer, asked = 503, {"detail": str(error)}, 0
        if status in (200, 201, 202):
            print("stored as" if status != 200 else "was there, as", answer["id"])
            for verdict in answer.get("verdicts", []):
                if verdict["state"] != "within":
                    print(verdict["serial"], verdict["coefficient"], verdict["state"], verdict["reason"])
            return 0
        if status not in (408, 425, 429) and status < 500:
            print("refused:", answer.get("detail", status), file=sys.stderr)
            return 1
        print("try again:", answer.get("detail", status), file=sys.stderr)
        time.sleep(max(asked, pause))
        pause = min(2 * pause, 60.0)


if __name__ == "__main__":
    sys.exit(main())
