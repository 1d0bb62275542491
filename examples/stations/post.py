#!/usr/bin/env python3
"""Send a campaign, record or bench result; read the answer; try again where that can help. Needs Python 3 alone.

    GYROWATCH_URL=http://127.0.0.1:8080 GYROWATCH_TOKEN=... python3 post.py campaign.json

LC_ALL or LANG (zh_CN.UTF-8) choose the language of what is refused.
Ends with 0 where the service has it (sending twice is harmless), with 1 where the file, the address or the
token is at fault, with 2 where the service was not reached or never took it. What is wrong is one line on standard error.
"""
import http.client
import json
import os
import sys
import time
import urllib.error
import urllib.request


PAUSES = [1, 2, 5, 10, 30, 60, 60]  # s, before it is sent again


def kind_of(text):
    """Path and content type of a document."""
    if not text.lstrip().startswith("{"):
        return "/v1/campaigns", "text/csv"
    members = json.loads(text)
    path = "campaigns" if "dwells" in members else "records" if "gyros" in members else "bench-results"
    return "/v1/" + path, "application/json"


def send(url, token, body, path, content_type):
    """Status, answer, and for how many seconds the service asks to wait."""
    language = (os.environ.get("LC_ALL") or os.environ.get("LANG") or "en")[:2]
    headers = {"Content-Type": content_type, "Accept-Language": language if language.isalpha() else "en"}
    request = urllib.request.Request(url + path, data=body, headers=headers)
    if token:
        request.add_header("Authorization", "Bearer " + token)
    try:
        with urllib.request.urlopen(request, timeout=120) as answer:
            stored = json.load(answer)
            if "id" not in stored:
                raise ValueError("another program answers there")
            return answer.status, stored, 0
    except urllib.error.HTTPError as refused:
        text = refused.read()
        try:
            problem = {"detail": json.loads(text)["detail"]}
        except (ValueError, KeyError, TypeError):
            problem = {"detail": " ".join(text.decode(errors="replace").split())[:200]}
        return refused.code, problem, float(refused.headers.get("Retry-After") or 0)


def main():
    if len(sys.argv) != 2:
        sys.exit("usage: post.py FILE")
    url = os.environ.get("GYROWATCH_URL", "http://127.0.0.1:8080").rstrip("/")
    token = os.environ.get("GYROWATCH_TOKEN")
    if not url.startswith(("http://", "https://")):
        sys.exit(f"GYROWATCH_URL: {url} is no address such as http://127.0.0.1:8080")
    try:
        with open(sys.argv[1], "rb") as file:
            body = file.read()
        path, content_type = kind_of(body.decode("utf-8-sig"))
    except (OSError, ValueError) as error:
        sys.exit(f"{sys.argv[1]}: cannot be sent: {error}")
    for pause in PAUSES + [None]:
        try:
            status, answer, asked = send(url, token, body, path, content_type)
        except (OSError, ValueError, http.client.HTTPException) as error:
            status, answer, asked = 503, {"detail": f"no answer of gyrowatch at {url}: {error}"}, 0
        if status in (200, 201, 202):
            print("stored as" if status != 200 else "was there, as", answer["id"])
            for verdict in answer.get("verdicts", []):
                if verdict["state"] != "within":
                    print(verdict["serial"], verdict["coefficient"], verdict["state"], verdict["reason"])
            return 0
        if status not in (408, 425, 429) and status < 500:
            print(f"refused ({status}):", answer.get("detail", status), file=sys.stderr)
            return 1
        if pause is None:
            print("given up:", answer.get("detail", status), file=sys.stderr)
            return 2
        print("try again:", answer.get("detail", status), file=sys.stderr)
        time.sleep(max(asked, pause))


if __name__ == "__main__":
    sys.exit(main())
