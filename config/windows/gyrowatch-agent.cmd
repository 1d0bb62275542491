@echo off
rem What the task runs. Change these two lines.
set GYROWATCH_URL=https://gyros.example:8443
set OUTBOX=%~dp0outbox

"%~dp0gyrowatch.exe" import --watch "%OUTBOX%" --token-file "%~dp0station.token" >>"%~dp0agent.log" 2>&1
