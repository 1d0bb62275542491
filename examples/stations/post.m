% Send a file from MATLAB (R2016b or later); read the answer; try again where that can help.
%   answer = post('campaign.csv', 'campaigns', 'text/csv')
function answer = post(file, kind, type)
    if nargin < 2, kind = 'campaigns'; end
    if nargin < 3, type = 'application/json'; end
    url = [getenv_or('GYROWATCH_URL', 'http://127.0.0.1:8080') '/v1/' kind];
    text = fileread(file);
    headers = {};
    token = getenv('GYROWATCH_TOKEN');
    if ~isempty(token), headers = {'Authorization', ['Bearer ' token]}; end
    options = weboptions('MediaType', type, 'RequestMethod', 'post', 'Timeout', 120, 'HeaderFields', headers);
    pauses_s = [1 2 5 10 30 60 60];
    for attempt = 0:numel(pauses_s)
        try
            % A char array is sent as it is; a struct would be written anew by jsonencode.
            answer = webwrite(url, text, options);
            return
        catch problem
            % MATLAB:webservices:HTTP422StatusCodeError and the like: the file is at fault.
            code = sscanf(problem.identifier, 'MATLAB:webservices:HTTP%d');
            if ~isempty(code) && code < 500 && ~any(code == [408 425 429]), rethrow(problem); end
            if attempt == numel(pauses_s), rethrow(problem); end
            warning('gyrowatch:again', 'try again in %g s: %s', pauses_s(attempt + 1), problem.message);
            pause(pauses_s(attempt + 1));
        end
    end
end

function value = getenv_or(name, otherwise)
    value = getenv(name);
    if isempty(value), value = otherwise; end
end
